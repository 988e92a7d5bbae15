// The balance of the card: to one scale, to the right what opens the gap, to the left what closes it; a pointer shows the sum, ḋ.
(() => {
  const HEIGHT = 22;
  const BAR = 11;
  const set = duet.set;

  const patterns = (root) => {
    const defs = duet.svg(root, "defs");
    const hatch = (kind, width, mark) => {
      const size = { width, height: width, patternUnits: "userSpaceOnUse" };
      const pattern = duet.svg(defs, "pattern", { id: `duet-fill-${kind}`, ...size, patternTransform: "rotate(45)" });
      duet.svg(pattern, "rect", { class: `${kind} pale`, width, height: width });
      mark(pattern);
    };
    hatch("u", 5, (pattern) => duet.svg(pattern, "rect", { class: "u", width: 2.6, height: 5 }));
    hatch("w", 5, (pattern) => duet.svg(pattern, "circle", { class: "w", cx: 2.5, cy: 2.5, r: 1.8 }));
  };

  // Builds the balance in an <svg>; returns a function that draws the parts of ḋ [mm/s].
  duet.contactBalance = (root, words, width) => {
    root.replaceChildren();
    set(root, { viewBox: `0 0 ${width} ${HEIGHT}` });
    patterns(root);
    const bars = words.terms.map(([kind]) => {
      const fill = kind === "u" || kind === "w" ? `url(#duet-fill-${kind})` : "currentColor";
      return duet.svg(root, "rect", { class: `${kind} bar`, "data-symbol": kind, fill, y: 2, height: BAR });
    });
    const half = duet.svg(root, "path", { class: "half" });
    const middle = width / 2;
    const reach = middle - 14;
    const bound = duet.svg(root, "path", { class: "v bound" });
    duet.svg(root, "line", { class: "pivot", x1: middle, x2: middle, y1: 0, y2: BAR + 4 });
    const heads = ["left", "right"].map(() => duet.svg(root, "path"));
    const [closes, opens] = words.ways.map((text) => {
      const label = duet.svg(root, "text", { class: "tick", y: BAR + 1 });
      label.textContent = text;
      return label;
    });
    set(opens, { x: width, "text-anchor": "end" });
    const sum = duet.svg(root, "path", { class: "sum", "data-symbol": "d" });

    let scale = 0;
    let rooms = [0, 0];
    return (values, allowed) => {
      const side = (sign) => values.reduce((total, value) => total + Math.max(sign * value, 0), 0);
      const most = Math.max(side(1), side(-1));
      // In steps of two, and back only with room to spare, so that the scale does not breathe.
      const usual = reach / Math.max(1.5 * words.v, 400);
      if (scale === 0) scale = usual;
      while (most * scale > reach) scale /= 2;
      while (scale < usual && most * scale * 3 < reach) scale *= 2;
      const ends = [middle, middle];
      const last = ["", ""];
      // From the pivot outwards: to the left the task, then the approach.
      for (let i = values.length - 1; i >= 0; i--) {
        const right = values[i] >= 0 ? 1 : 0;
        const length = Math.abs(values[i]) * scale;
        const from = right ? ends[1] : ends[0] - length;
        set(bars[i], { x: from.toFixed(1), width: length.toFixed(1) });
        ends[right] += right ? length : -length;
        if (length > 1) last[right] = words.terms[i][0];
        // Two arms retreat.
        if (words.two && words.terms[i][0] === "v") set(half, { d: `M${(from + length / 2).toFixed(1)},1v${BAR + 2}` });
      }
      heads.forEach((head, right) => {
        const way = right ? 7 : -7;
        const long = Math.abs(ends[right] - middle) > 3;
        set(head, {
          class: `${last[right]} head`,
          d: long ? `M${ends[right].toFixed(1)},-1l${way},${BAR / 2 + 3}l${-way},${BAR / 2 + 3}z` : "",
        });
      });
      // A word of what a side does, where its bar leaves room. Measuring it in every frame would lay out the page each time.
      if (!rooms[0]) rooms = [closes, opens].map((label) => label.getComputedTextLength());
      set(closes, { visibility: ends[0] > rooms[0] + 14 ? "visible" : "hidden" });
      set(opens, { visibility: width - ends[1] > rooms[1] + 14 ? "visible" : "hidden" });
      const at = middle + values.reduce((total, value) => total + value, 0) * scale;
      set(sum, { d: `M${at.toFixed(1)},${BAR + 3}l-5,8h10z` });
      const edge = allowed === null ? 0 : middle - Math.min(allowed * scale, middle - 4);
      set(bound, { d: allowed === null ? "" : `M${edge.toFixed(1)},0h4m-4,0v${BAR + 4}h4` });
    };
  };
})();
