// Follows the language that the server says the page has; the page's own `lang` tells a screen reader which voice to use.
setInterval(() => {
  const found = document.querySelector(".duet-language")?.dataset;
  if (!found) return;
  if (document.documentElement.lang !== found.language) document.documentElement.lang = found.language;
  duet.setLanguage(found.words);
}, 500);
