// Lights a symbol wherever it is when the pointer or the focus is on it anywhere: in formulas, in the captions of the plots, in the
// card of the line of contact, its curve in the plots, and its body in the scene.
addEventListener("DOMContentLoaded", () => {
  const PLACES = [".duet-eq", ".duet-lesson svg", ".duet-caption", "#duet-contact"];
  const SYMBOLS = ["lam", "dm", "rest", "d", "v", "u", "w", "e"];
  const ANY = SYMBOLS.map((symbol) => `.${symbol}`).join();
  // Names of a symbol's curves, where they differ from its own.
  const CURVES = { lam: ["lambda"], dm: ["d_m"], rest: ["d*"], e: ["e", "e2"] };
  let lit = "";
  // Selector of every symbol that is marked in one of the places.
  duet.symbolsOnPage = PLACES.map((place) => `${place} :is([data-symbol],${ANY})`).join();

  const symbolAt = (target) => {
    if (!target?.closest?.(PLACES.join())) return "";
    const marked = target.closest("[data-symbol]");
    if (marked) return marked.dataset.symbol;
    const classes = target.closest(ANY)?.classList;
    return SYMBOLS.find((symbol) => classes?.contains(symbol)) ?? "";
  };

  duet.symbolAt = symbolAt;

  // A body of the scene takes on the symbol's colour by its own material; a line gets wider.
  const bodies = new Map();
  const lightBodies = (names, colour) => {
    const scene = window.__viserMutable;
    if (!scene?.nodeRefFromName) return;
    for (const [material, undo] of bodies) undo(material);
    bodies.clear();
    // A name without a slash at its beginning is a part of the node's name.
    const nodes = Object.keys(scene.nodeRefFromName).filter((node) =>
      names.some((name) => (name.startsWith("/") ? node === name : node.includes(name))),
    );
    for (const node of nodes)
      scene.nodeRefFromName[node]?.traverse(({ material }) => {
        if (!material || Array.isArray(material) || bodies.has(material)) return;
        if (material.linewidth > 1) {
          const width = material.linewidth;
          material.linewidth = 2.5 * width;
          bodies.set(material, (own) => {
            own.linewidth = width;
          });
        } else if (material.transparent) {
          const opacity = material.opacity;
          material.opacity = Math.min(2.5 * opacity, 1);
          bodies.set(material, (own) => {
            own.opacity = opacity;
          });
        } else if (material.color) {
          const before = material.color.clone();
          material.color.lerp(before.clone().setStyle(colour), 0.7);
          bodies.set(material, (own) => {
            own.color.copy(before);
            // A tint that λ has changed meanwhile is made again.
            delete own.userData.duetShare;
          });
        }
      });
    scene.requestRender?.();
  };

  // The other curves of its plot fade.
  const lightCurves = (symbol) => {
    const names = CURVES[symbol] ?? [symbol];
    for (const { chart } of Object.values(window.__viserTestpoints?.uplots ?? {})) {
      const curve = chart.series.findIndex(({ label }, place) => place > 0 && names.includes(label));
      chart.setSeries(curve > 0 ? curve : null, { focus: true });
    }
  };

  const light = (symbol) => {
    if (symbol === lit) return;
    lit = symbol;
    for (const one of document.querySelectorAll(".duet-lit")) one.classList.remove("duet-lit");
    if (symbol)
      for (const one of document.querySelectorAll(
        PLACES.map((place) => `${place} :is([data-symbol=${symbol}],.${symbol})`).join(),
      ))
        one.classList.add("duet-lit");
    const shown = document.querySelector(`#duet-contact .${symbol || "none"}`);
    lightCurves(symbol);
    lightBodies(duet.bodies?.[symbol] ?? [], shown ? getComputedStyle(shown).color : "");
  };
  // The sentence of a symbol lies outside of it: the symbol stays lit while the pointer is on that.
  for (const kind of ["pointerover", "focusin"])
    addEventListener(kind, ({ target }) => target?.closest?.(".duet-says") || light(symbolAt(target)));
  addEventListener("focusout", () => light(""));
});
