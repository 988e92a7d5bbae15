// Says on the page that the browser has taken the picture's WebGL context away, until it is given back. These events do not bubble, so
// that they are caught on their way down to the canvas.
(() => {
  let note = null;
  const ours = (event) => event.target === window.__viserMutable?.canvas;
  addEventListener(
    "webglcontextlost",
    (event) => {
      if (!ours(event) || note) return;
      note = document.createElement("div");
      note.id = "duet-lost-picture";
      note.setAttribute("role", "alert");
      document.body.append(note);
      note.textContent = duet.translate(duet.pictureLost);
    },
    true,
  );
  addEventListener(
    "webglcontextrestored",
    (event) => {
      if (!ours(event)) return;
      note?.remove();
      note = null;
    },
    true,
  );
})();
