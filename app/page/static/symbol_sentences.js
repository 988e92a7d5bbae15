// Says what a symbol means, in one sentence beside it, when the pointer, a finger or the focus is on it. The server sends the sentences in
// `.duet-contact-symbols`; each is a tooltip that describes its symbols to a screen reader, too.
addEventListener("DOMContentLoaded", () => {
  const GAP = 5;
  const EDGE = 6;
  // Time to bring the pointer from a symbol to its sentence.
  const LINGER_MS = 300;
  const IDENT = "duet-says-";
  // Symbols that keys reach: those of formulas have a box of their own already, see `live_equations.js`.
  const REACHED = "#duet-contact :is(.gap,.term,.legend span), .duet-caption :is(b,span)";
  const IN_TEXT = ".duet-lesson svg:not([role=group])";
  const COVERED = "button, input, a, select, textarea, [role=slider]";
  const tooltips = new Map();
  let sent = "";
  let shown = null;
  let leaving = 0;

  const kindOf = (target) => {
    const symbol = duet.symbolAt(target);
    const kind = target.closest?.("[data-says]")?.dataset.says ?? (target.closest?.(".law") ? "law" : symbol);
    return symbol && tooltips.has(kind) ? kind : "";
  };
  // The element that is the symbol: pointing meets a part of it.
  const elementOf = (target) => target.closest("[data-symbol]") ?? target.closest(duet.symbolsOnPage) ?? target;

  const hide = () => {
    clearTimeout(leaving);
    leaving = 0;
    if (shown) shown.tooltip.hidden = true;
    shown = null;
  };

  const overlap = (a, b) =>
    Math.max(0, Math.min(a.right, b.right) - Math.max(a.left, b.left)) *
    Math.max(0, Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top));

  // Beside the symbol, or else beside all of its formula, caption or card: where it covers least of other symbols and of controls.
  const place = (tooltip, element) => {
    const { width, height } = tooltip.getBoundingClientRect();
    const symbol = element.getBoundingClientRect();
    const around = element.closest("#duet-contact, .duet-caption, .duet-eq, .duet-formula") ?? element;
    const middle = Math.min(Math.max((symbol.left + symbol.right - width) / 2, EDGE), innerWidth - EDGE - width);
    const candidates = [symbol, around.getBoundingClientRect()].flatMap((box) => [
      { left: middle, top: box.bottom + GAP },
      { left: middle, top: box.top - GAP - height },
      { left: box.right + GAP, top: symbol.top },
      { left: box.left - GAP - width, top: symbol.top },
    ]);
    const others = [...document.querySelectorAll(`${duet.symbolsOnPage}, ${COVERED}`)]
      .filter((other) => !other.contains(element) && !element.contains(other))
      .map((other) => other.getBoundingClientRect());
    let best = null;
    for (const { left, top } of candidates) {
      const box = { left, top, right: left + width, bottom: top + height };
      const inside = left >= EDGE && top >= EDGE && box.right <= innerWidth - EDGE && box.bottom <= innerHeight - EDGE;
      const covered = others.reduce((sum, other) => sum + overlap(box, other), overlap(box, symbol));
      if (inside && (!best || covered < best.covered)) best = { covered, left, top };
      if (best?.covered === 0) break;
    }
    best ??= { left: middle, top: EDGE };
    tooltip.style.left = `${best.left}px`;
    tooltip.style.top = `${best.top}px`;
  };

  const show = (target) => {
    const kind = kindOf(target);
    if (!kind) return false;
    const element = elementOf(target);
    clearTimeout(leaving);
    leaving = 0;
    if (shown?.element === element) return true;
    hide();
    const tooltip = tooltips.get(kind);
    tooltip.hidden = false;
    shown = { tooltip, element };
    place(tooltip, element);
    return true;
  };

  // A finger leaves its sentence where it is until it touches something else.
  addEventListener("pointerover", ({ target }) => {
    if (shown?.tooltip.contains(target)) {
      clearTimeout(leaving);
      leaving = 0;
    } else if (!show(target) && shown && !leaving) leaving = setTimeout(hide, LINGER_MS);
  });
  addEventListener("focusin", ({ target }) => show(target) || hide());
  addEventListener("focusout", hide);
  addEventListener("keydown", ({ key }) => key === "Escape" && hide(), true);
  for (const kind of ["scroll", "resize"]) addEventListener(kind, hide, true);

  const describe = (element) => {
    const kind = kindOf(element);
    if (!kind || element.getAttribute("aria-describedby") === IDENT + kind) return;
    element.setAttribute("aria-describedby", IDENT + kind);
    if (element.hasAttribute("tabindex")) return;
    duet.set(element, { tabindex: 0, role: "img", "data-described": "" });
  };

  const look = () => {
    const text = document.querySelector(".duet-contact-symbols")?.dataset.text ?? "";
    if (text && text !== sent) {
      sent = text;
      for (const [kind, sentence] of Object.entries(JSON.parse(text))) {
        if (!tooltips.has(kind)) {
          const tooltip = document.createElement("div");
          Object.assign(tooltip, { id: IDENT + kind, className: "duet duet-says", role: "tooltip", hidden: true });
          document.body.append(tooltip);
          tooltips.set(kind, tooltip);
        }
        duet.say(sentence, tooltips.get(kind));
      }
    }
    if (shown && !shown.element.isConnected) hide();
    for (const element of document.querySelectorAll(`.hit[data-symbol], ${REACHED}`)) describe(element);
    // In the text of a lesson the first of each symbol is enough: another stop at every letter would be in the way.
    const met = new Set();
    for (const glyph of document.querySelectorAll(`${IN_TEXT} path`)) {
      const kind = kindOf(glyph);
      if (!kind || met.has(kind)) continue;
      met.add(kind);
      describe(glyph);
    }
    for (const element of document.querySelectorAll("[data-described]")) {
      const label = element.textContent.trim() || sentenceName(element);
      if (element.getAttribute("aria-label") !== label) element.setAttribute("aria-label", label);
    }
  };
  const sentenceName = (element) => tooltips.get(kindOf(element))?.textContent.split(":")[0] ?? "";
  setInterval(look, 200);
});
