// Says how large the 3-D picture is, and how high the plots cover it, as soon as either changes.
addEventListener("DOMContentLoaded", () => {
  const LOOK_MS = 250;
  // Plots that change their colours are off the page for a moment, and nothing should move for that: lower plots are said once they last.
  const LASTS_LOOKS = 3;
  let box = "";
  let plots = null;
  let said = "";
  let seen = "";
  let looks = 0;

  setInterval(() => {
    const scene = window.__viserMutable;
    // A folded panel is not on the page, nor what marks it.
    const found = document.querySelector("[data-duet-picture]")?.dataset.duetPicture ?? box;
    if (found !== box) {
      box = found;
      said = "";
    }
    if (!box || !scene?.canvas?.isConnected || document.hidden) return;
    plots = document.querySelector("[data-duet-holds~=plots]") ?? (plots?.isConnected ? plots : null);
    plots ??= document.querySelector("[data-floating-window]");
    const picture = scene.canvas.getBoundingClientRect();
    const { top, height } = plots?.getBoundingClientRect() ?? picture;
    const covered = plots && height > 0 ? Math.max(picture.bottom - top, 0) : 0;
    const size = `${[innerWidth, picture.width, picture.height].map(Math.round).join(" ")} `;
    const now = size + Math.round(covered);
    looks = now === seen ? looks + 1 : 1;
    seen = now;
    const lower = said.startsWith(size) && covered < Number(said.split(" ")[3]);
    if (now === said || (lower && looks < LASTS_LOOKS)) return;
    said = now;
    scene.sendMessage({ type: "GuiUpdateMessage", uuid: box, updates: { value: now } });
  }, LOOK_MS);
});
