// Reads out what the lessons say, and begins every part of a step at its top.
addEventListener("DOMContentLoaded", () => {
  const live = document.createElement("div");
  live.id = "duet-say";
  live.setAttribute("role", "status");
  live.setAttribute("aria-live", "polite");
  document.body.append(live);

  const PHONE_WIDTH = 577;
  let announced = "";
  let part = "";
  let scrolls = 0;
  const announce = () => {
    const text = Array.from(document.querySelectorAll(".duet-say"), (element) => element.innerText).join(" ");
    if (text === announced) return;
    announced = text;
    live.textContent = text;
  };
  const scrollToTop = () => {
    const head = document.querySelector(".duet-l-head, .duet-l-list");
    // Without what pointing at a symbol does to it.
    const shown = head ? head.innerHTML.replaceAll(/ ?duet-lit| class=""/g, "") : "";
    const phone = innerWidth < PHONE_WIDTH;
    if (shown !== part) {
      part = shown;
      // A phone's sheet takes a moment to unfold.
      scrolls = head ? (phone ? 8 : 1) : 0;
    }
    if (scrolls === 0) return;
    scrolls--;
    // A verdict is above the head.
    (document.querySelector(".duet-l-verdict") ?? head).scrollIntoView({ block: "start" });
  };
  setInterval(() => {
    announce();
    scrollToTop();
  }, 300);
  const stop = () => {
    scrolls = 0;
  };
  for (const kind of ["pointerdown", "wheel", "keydown"]) addEventListener(kind, stop, true);
});
