// In a frame of another page (`?embed=1`): the scene, the card and few controls. Arrow keys that nothing here takes go to the page around,
// in the words of reveal.js, so that a deck of slides goes on.
(() => {
  if (new URLSearchParams(location.search).get("embed") !== "1") return;
  document.documentElement.classList.add("duet-embed");
  duet.query.panel = "small";
  const methods = { ArrowLeft: "left", ArrowRight: "right", ArrowUp: "up", ArrowDown: "down", PageUp: "prev", PageDown: "next" };
  const relay = (event) => {
    const method = methods[event.key];
    if (!method || event.ctrlKey || event.metaKey || event.altKey || event.shiftKey) return;
    if (event.target instanceof Element && event.target.closest(duet.widgets)) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    // No secret, and the page around may have any address that the server allows.
    if (parent !== window) parent.postMessage(JSON.stringify({ method, key: event.key }), "*");
  };
  addEventListener("keydown", relay, true);
})();
