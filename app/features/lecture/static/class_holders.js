// What a class adds to the words of `data-duet-holds`, see `holders.js`.
{
  const { words, above, around } = duet.holders;
  words.banner = [".duet-banner", above(1)];
  words.follows = [".duet-banner:not(.own)", around(":root")];
  words.watches = [".duet-banner.watches", around(":root")];
  words.curves = [".duet-poll figure", (held) => above(2)(held.closest(".duet-poll"))];
}
