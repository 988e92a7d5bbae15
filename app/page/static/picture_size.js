// Says how large the 3-D picture is, how high the plots cover it, and to where the card does, as soon as any of them changes; and marks
// the page while its plots are slim.
addEventListener("DOMContentLoaded", () => {
  const LOOK_MS = 250;
  // Plots that change their colours are off the page for a moment, and nothing should move for that: lower plots are said once they last.
  const LASTS_LOOKS = 3;
  // A card that has less to say for a moment gives no room back, and one line more or less is not worth a message.
  const CARD_LOOKS = 24;
  const CARD_STEP = 12;
  // Between two panels the plots may have no room for two side by side [px].
  const SLIM = 300;
  const SHEET = '.mantine-Paper-root[style*="max-height: 60%"]';
  let box = "";
  let plots = null;
  let said = "";
  let seen = "";
  let looks = 0;
  let cardSaid = "0 0";
  let cardLooks = 0;

  const cardEnds = (picture) => {
    const { right, bottom, height } = document.getElementById("duet-contact")?.getBoundingClientRect() ?? {};
    if (!height) return "0 0";
    const ends = [right - picture.left, Math.ceil((bottom - picture.top) / CARD_STEP) * CARD_STEP];
    return ends.map((end) => Math.max(Math.round(end), 0)).join(" ");
  };

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
    const width = plots?.getBoundingClientRect().width ?? 0;
    document.documentElement.classList.toggle("duet-slim", width > 0 && width < SLIM);
    plots ??= document.querySelector("[data-floating-window]");
    // On the phone of one who follows another's page the sheet is higher than on others.
    if (document.documentElement.dataset.duetHolds?.includes("follows")) plots = document.querySelector(SHEET) ?? plots;
    const picture = scene.canvas.getBoundingClientRect();
    const { top, height } = plots?.getBoundingClientRect() ?? picture;
    const covered = plots && height > 0 ? Math.max(picture.bottom - top, 0) : 0;
    const size = `${[innerWidth, picture.width, picture.height].map(Math.round).join(" ")} `;
    const ends = cardEnds(picture);
    cardLooks = ends === cardSaid ? 0 : cardLooks + 1;
    if (Number(ends.split(" ")[1]) > Number(cardSaid.split(" ")[1]) || cardLooks >= CARD_LOOKS) cardSaid = ends;
    const now = `${size}${Math.round(covered)} ${cardSaid}`;
    looks = now === seen ? looks + 1 : 1;
    seen = now;
    const lower = said.startsWith(size) && covered < Number(said.split(" ")[3]);
    if (now === said || (lower && looks < LASTS_LOOKS)) return;
    said = now;
    scene.sendMessage({ type: "GuiUpdateMessage", uuid: box, updates: { value: now } });
  }, LOOK_MS);
});
