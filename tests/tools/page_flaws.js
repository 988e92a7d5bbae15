// Returns what is wrong with the texts that a page shows now; see page_flaws.py.
() => {
  const MARGIN = 1.5, found = new Set(), shown = [];
  const name = (element, text) => `${element.tagName.toLowerCase()}.${String(element.className?.baseVal ?? element.className).slice(0, 40)}: ` +
    text.trim().replace(/\s+/g, " ").slice(0, 60);
  // What a box shows of what is in it; a box that scrolls along an axis hides nothing for good.
  const clipped = (element, axis) => {
    const box = { left: 0, top: 0, right: innerWidth, bottom: innerHeight, scrolls: false };
    for (let at = element; at && at !== document.documentElement; at = at.parentElement) {
      const style = getComputedStyle(at), overflow = style[`overflow${axis}`];
      if (overflow !== "visible" && style.display !== "inline") {
        const edge = at.getBoundingClientRect();
        if (overflow === "auto" || overflow === "scroll") box.scrolls = true;
        for (const side of ["left", "top"]) box[side] = Math.max(box[side], edge[side]);
        for (const side of ["right", "bottom"]) box[side] = Math.min(box[side], edge[side]);
      }
      if (style.position === "fixed") break;
    }
    return box;
  };
  const seen = (element) => element.checkVisibility({ opacityProperty: true, visibilityProperty: true }) &&
    !element.closest(".sr-only, [aria-hidden=true], [inert], noscript, style, script, select, option, .uplot") &&
    getComputedStyle(element).clip === "auto" && getComputedStyle(element).clipPath === "none";
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let node = walker.nextNode(); node; node = walker.nextNode()) {
    const element = node.parentElement;
    if (!node.data.trim() || !seen(element) || !element.getClientRects().length) continue;
    const range = document.createRange();
    range.selectNodeContents(node);
    for (const line of range.getClientRects()) {
      if (line.width < 2 || line.height < 2) continue;
      const x = clipped(element, "X"), y = clipped(element, "Y");
      const out = line.bottom < y.top + 2 || line.top > y.bottom - 2 || line.right < x.left + 2 || line.left > x.right - 2;
      if (out && (x.scrolls || y.scrolls)) continue;
      if (!x.scrolls && (line.left < x.left - MARGIN || line.right > x.right + MARGIN)) found.add("cut at a side: " + name(element, node.data));
      // Letters do not fill their line from top to bottom.
      if (!y.scrolls && (line.top < y.top - line.height / 4 || line.bottom > y.bottom + line.height / 4)) found.add("cut above or below: " + name(element, node.data));
      const at = [Math.min(Math.max((line.left + line.right) / 2, x.left), x.right), (line.top + line.bottom) / 2];
      if (at[1] <= y.top || at[1] >= y.bottom) continue;
      const top = document.elementFromPoint(...at);
      if (getComputedStyle(element).pointerEvents !== "none" && top && !top.contains(element) && !element.contains(top) && !element.closest("label, button")?.contains(top))
        found.add(`covered by ${name(top, "")}: ${name(element, node.data)}`);
      shown.push([line, element, node.data]);
    }
  }
  for (let i = 0; i < shown.length; i++)
    for (let k = i + 1; k < shown.length; k++) {
      const [a, one, said] = shown[i], [b, other, text] = shown[k];
      if (one === other || one.contains(other) || other.contains(one)) continue;
      const width = Math.min(a.right, b.right) - Math.max(a.left, b.left), height = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
      if (width > 3 && height > 0.4 * Math.min(a.height, b.height)) {
        const x = (Math.max(a.left, b.left) + Math.min(a.right, b.right)) / 2, y = (Math.max(a.top, b.top) + Math.min(a.bottom, b.bottom)) / 2;
        // Of two layers only the upper one is read.
        const stack = document.elementsFromPoint(x, y), first = stack.indexOf(one), second = stack.indexOf(other);
        if (first < 0 || second < 0) continue;
        if (stack.slice(Math.min(first, second), Math.max(first, second)).some(el => el !== one && el !== other && getComputedStyle(el).backgroundColor !== "rgba(0, 0, 0, 0)")) continue;
        found.add(`over each other: ${name(one, said)} | ${name(other, text)}`);
      }
    }
  for (const box of document.querySelectorAll("[data-testid=floating-panel], [data-floating-window]")) {
    const { left, top, right, bottom, width } = box.getBoundingClientRect();
    if (width && (left < -1 || top < -1 || right > innerWidth + 1 || bottom > innerHeight + 1))
      found.add(`beyond the window: ${box.dataset.testid ?? "plots"} ${[left, top, right, bottom].map(Math.round)}`);
  }
  if (document.documentElement.scrollWidth > innerWidth + 1) found.add("too wide: the page itself");
  const boxes = "label, button, [role=tab], .mantine-Button-label, .duet, .duet *, .duet-caption, .duet-caption *";
  for (const box of document.querySelectorAll(boxes)) {
    // A formula may be wider than its place, and is then moved by hand.
    if (box.closest("svg, pre, .duet-formula") || !box.clientWidth || !box.textContent.trim() || !seen(box)) continue;
    // What sticks out of viser's own boxes may do so, and so does the lever of a card.
    if (getComputedStyle(box).overflowX === "visible" && (!box.closest(".duet, .duet-caption") || box.querySelector(".lever"))) continue;
    if (box.scrollWidth > box.clientWidth + 1) found.add(`too wide: ${name(box, box.textContent)}, ${box.scrollWidth} px in ${box.clientWidth}`);
  }
  return [...found];
}
