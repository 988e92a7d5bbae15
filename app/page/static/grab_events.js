// Lets viser's client do what it tries when a link is grabbed: it calls `preventDefault` in listeners that react-three-fiber adds as passive
// ones, which a browser counts as an error at every grab.
(() => {
  const add = EventTarget.prototype.addEventListener;
  const grabs = new Set(["pointerdown", "contextmenu"]);
  EventTarget.prototype.addEventListener = function (kind, listener, options) {
    return add.call(this, kind, listener, grabs.has(kind) && options?.passive ? { ...options, passive: false } : options);
  };
})();
