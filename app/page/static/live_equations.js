// Writes this moment's numbers into formulas, above or below their symbols: into the law's equation, and into those that explain a step.
addEventListener("DOMContentLoaded", () => {
  const FORMULAS = ".duet-eq svg, .duet-l-explain .duet-formula svg";
  const SYMBOLS = ["lam", "dm", "d", "v", "u", "w", "e"];
  const FONT = '600 12px system-ui,-apple-system,"Segoe UI",Roboto,"Noto Sans","Liberation Sans",sans-serif';
  const ROW = 14;
  const live = new Map();

  // One place for every symbol, whose glyphs stand side by side: {kind, box}.
  const symbols = (svg) => {
    const found = [];
    let before = "";
    for (const path of svg.querySelectorAll("path")) {
      const symbol = SYMBOLS.find((symbol) => path.classList.contains(symbol)) ?? "";
      const kind = path.classList.contains("law") ? `${symbol} law` : symbol;
      if (kind) {
        const { x, y, width, height } = path.getBBox();
        const box = { left: x, top: y, right: x + width, bottom: y + height };
        const last = found.at(-1);
        if (kind === before)
          last.box = {
            left: Math.min(last.box.left, box.left),
            top: Math.min(last.box.top, box.top),
            right: Math.max(last.box.right, box.right),
            bottom: Math.max(last.box.bottom, box.bottom),
          };
        else found.push({ kind, box });
      }
      before = kind;
    }
    return found;
  };

  const prepare = (svg) => {
    const [left, top, width, height] = svg.getAttribute("viewBox").split(" ").map(Number);
    const bottom = top + height;
    const found = symbols(svg);
    const values = duet.symbols;
    // λ(d*) is not the λ of this moment.
    const elsewhere = svg.getAttribute("aria-label").includes("λ(d^*)");
    const marked = found.filter(({ kind }) => values[kind] !== undefined && !(elsewhere && kind === "lam"));
    const middle = (top + bottom) / 2;
    const glyphs = [...svg.querySelectorAll("path,rect")].map((glyph) => glyph.getBBox());
    const bounds = { left: left - 12, right: left + width + 12, top: top - 40, bottom: bottom + 40 };
    const placesOf = ({ kind, box }) => {
      const half = duet.textWidth(values[kind], FONT) / 2 + 1;
      const x = (box.left + box.right) / 2;
      const below = { top: bottom + 1, bottom: bottom + 1 + ROW };
      const above = { top: top - 1 - ROW, bottom: top - 1 };
      // Where another glyph lies in between, the number would be read as that one's.
      const clear = (row, place) =>
        !glyphs.some(
          (glyph) =>
            glyph.x < Math.max(box.right, place) &&
            glyph.x + glyph.width > Math.min(box.left, place) &&
            (row === below ? glyph.y > box.bottom - 1 : glyph.y + glyph.height < box.top + 1),
        );
      const first = (box.top + box.bottom) / 2 < middle - 6 ? [above, below] : [below, above];
      return first.flatMap((row) =>
        [x, x - 0.6 * half, x + 0.6 * half]
          .filter((place) => clear(row, place))
          .map((place) => ({ left: place - half, right: place + half, ...row })),
      );
    };
    const placed = (symbols) => {
      const numbers = [];
      for (const symbol of symbols) {
        // Once is enough: all symbols of a kind have the same number.
        if (numbers.some(({ kind }) => kind === symbol.kind)) continue;
        const taken = numbers.map(({ place }) => place);
        const [place] = duet.placeLabels([placesOf(symbol)], bounds, taken);
        if (place) numbers.push({ kind: symbol.kind, place });
      }
      return numbers;
    };
    // The first number may be what leaves the last one no room.
    const [forward, backward] = [placed(marked), placed([...marked].reverse())];
    const numbers = backward.length > forward.length ? backward : forward;
    const used = numbers.map(({ place }) => place);
    const texts = numbers.map(({ kind, place }) => {
      const at = { x: (place.left + place.right) / 2, y: place.bottom - 3, "text-anchor": "middle" };
      return { kind, node: duet.svg(svg, "text", { class: `${kind} live`, ...at }) };
    });
    // In the law's equation d may be another first task.
    const d = (svg.closest(".duet-eq") && duet.letter) || "d";
    // Behind the glyphs, and larger, to be met by a pointer.
    const first = svg.firstChild;
    for (const { kind, box } of found)
      svg.insertBefore(
        duet.svg(svg, "rect", {
          ...{ class: "hit", "data-symbol": kind.split(" ")[0], tabindex: 0, fill: "transparent", rx: 3 },
          "data-says": kind.split(" ").at(-1),
          ...{ role: "img", "aria-label": { lam: "λ", d, dm: `${d}ₘ`, "d law": `${d}_law` }[kind] ?? kind },
          ...{ x: box.left - 2, y: box.top - 3, width: box.right - box.left + 4, height: box.bottom - box.top + 6 },
        }),
        first,
      );
    const high = used.some((box) => box.bottom < middle) ? ROW + 2 : 0;
    const low = used.some((box) => box.top > middle) ? ROW + 2 : 0;
    const wide = used.some((box) => box.left < left || box.right > left + width) ? 12 : 0;
    duet.set(svg, {
      viewBox: `${left - wide} ${top - high} ${width + 2 * wide} ${height + high + low}`,
      width: width + 2 * wide,
      height: height + high + low,
      role: "group",
    });
    const least = Number.parseFloat(svg.style.minWidth);
    if (least) svg.style.minWidth = `${(least * (width + 2 * wide)) / width}px`;
    return texts;
  };

  setInterval(() => {
    const values = duet.symbols;
    if (!values) return;
    for (const svg of document.querySelectorAll(FORMULAS)) {
      // A folded panel has no boxes.
      if (!live.has(svg) && svg.getBoundingClientRect().width > 0) live.set(svg, prepare(svg));
    }
    for (const [svg, texts] of live) {
      if (!svg.isConnected) live.delete(svg);
      for (const { kind, node } of texts) {
        const text = values[kind] ?? "";
        if (node.textContent !== text) node.textContent = text;
      }
    }
  }, 150);
});
