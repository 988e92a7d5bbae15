// Says how large the 3-D picture is, and how high the plots cover it, as soon as either changes.
addEventListener("DOMContentLoaded", () => {
  const LOOK_MS = 250;
  let box = "";
  let plots = null;
  let said = "";

  setInterval(() => {
    const scene = window.__viserMutable;
    // A folded panel is not on the page, nor what marks it.
    const found = document.querySelector("[data-duet-picture]")?.dataset.duetPicture ?? box;
    if (found !== box) {
      box = found;
      said = "";
    }
    if (!box || !scene?.canvas?.isConnected || document.hidden) return;
    plots = document.querySelector("[data-floating-window]:has(.duet-plots)") ?? (plots?.isConnected ? plots : null);
    plots ??= document.querySelector("[data-floating-window]");
    const picture = scene.canvas.getBoundingClientRect();
    const covered = plots ? Math.max(picture.bottom - plots.getBoundingClientRect().top, 0) : 0;
    const now = [innerWidth, picture.width, picture.height, covered].map(Math.round).join(" ");
    if (now === said) return;
    said = now;
    scene.sendMessage({ type: "GuiUpdateMessage", uuid: box, updates: { value: now } });
  }, LOOK_MS);
});
