// The page of a full room: asks again by itself, and reloads as soon as there is a place.
(() => {
  document.title = duet.translate(document.title);
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
