// Finds places for labels: each takes the first of its candidates that stays inside and meets nothing placed before it.
// A box is {left, top, right, bottom}.
(() => {
  const GAP = 6;
  const meet = (a, b) => a.left < b.right + GAP && b.left < a.right + GAP && a.top < b.bottom && b.top < a.bottom;

  // Returns one box per list of candidates, null where none of them is free.
  duet.placeLabels = (labels, bounds, taken) => {
    const boxes = [...taken];
    return labels.map((candidates) => {
      const box = candidates.find(
        (one) =>
          one.left >= bounds.left &&
          one.right <= bounds.right &&
          one.top >= bounds.top &&
          one.bottom <= bounds.bottom &&
          !boxes.some((other) => meet(one, other)),
      );
      if (box) boxes.push(box);
      return box ?? null;
    });
  };

  const context = document.createElement("canvas").getContext("2d");
  const widths = new Map();
  // The width of a text; `font` as in CSS.
  duet.textWidth = (text, font) => {
    const key = `${font}|${text}`;
    if (!widths.has(key)) {
      if (widths.size > 500) widths.clear();
      context.font = font;
      widths.set(key, context.measureText(text).width);
    }
    return widths.get(key);
  };

  // Creates an SVG element with attributes in `parent`.
  duet.svg = (parent, name, attributes = {}) => {
    const made = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    parent.append(made);
    return made;
  };
  // A text that is written again, though it is the same, wakes every script that watches the page.
  duet.say = (text, node) => {
    if (node.textContent !== text) node.textContent = text;
  };
  duet.set = (node, attributes) => {
    for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  };
})();
