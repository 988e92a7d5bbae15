// The page of a full room: asks again by itself, and reloads as soon as there is a place.
(() => {
  document.title = duet.translate(document.title);
  try {
    const url = new URL(location.href);
    const key = sessionStorage.getItem("duetKey");
    if (key && !url.searchParams.has("key")) {
      // A teacher gets in though every place is taken, but the page has taken the key out of the address bar.
      url.searchParams.set("key", key);
      location.replace(url);
      return;
    }
  } catch {
    // The browser blocks storage for this page: the key has stayed in the address.
  }
  const ask = () =>
    fetch("healthz", { cache: "no-store" })
      .then((answer) => answer.json())
      .then((state) => {
        if (state.room) location.reload();
        else setTimeout(ask, 2500 + 1500 * Math.random());
      })
      .catch(() => setTimeout(ask, 5000));
  // Soon, as the place may be the one that this very tab is just giving up by a reload.
  setTimeout(ask, 300);
})();
