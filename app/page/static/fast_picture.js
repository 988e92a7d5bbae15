// Asks for less where the browser draws without a graphics card (software_rendering.js): the fast picture, unless the link chose the
// fine one; no smoothed edges, which cost a third of a picture's time; and a picture for a change alone, as viser draws on for a quarter
// of a second after each, and where a picture takes 20 ms, the next change waits behind pictures in which nothing is new.
(() => {
  if (!duet.drawnBySoftware) return;
  duet.query.picture = "fast";

  // So long after the last change the page draws once more [ms]: what a browser prepares beside its frames is seen then.
  const TAIL_MS = 400;
  // viser draws for 250 ms, counted from `performance.now()`, and offers no other way to shorten it.
  const SKIPPED_MS = 248;
  let mutable;
  let draw = () => {};
  let tail = 0;
  const drawOnce = () => {
    const now = performance.now;
    performance.now = () => now.call(performance) - SKIPPED_MS;
    try {
      draw();
    } finally {
      delete performance.now;
    }
    clearTimeout(tail);
    tail = setTimeout(() => draw(), TAIL_MS);
  };
  Object.defineProperty(window, "__viserMutable", {
    configurable: true,
    get: () => mutable,
    set: (found) => {
      mutable = found;
      draw = found.requestRender;
      Object.defineProperty(found, "requestRender", {
        configurable: true,
        enumerable: true,
        get: () => drawOnce,
        set: (own) => {
          draw = own;
        },
      });
    },
  });

  if (new URLSearchParams(location.search).get("picture") === "fine") return;
  const getContext = HTMLCanvasElement.prototype.getContext;
  HTMLCanvasElement.prototype.getContext = function (kind, options) {
    return getContext.call(this, kind, /^webgl/.test(kind) ? { ...options, antialias: false } : options);
  };
})();
