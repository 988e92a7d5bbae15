// Moves a hint of viser's to where it covers no control: below or above its own control, or beside the panel.
addEventListener("DOMContentLoaded", () => {
  const GAP = 6;
  const EDGE = 6;
  const CONTROLS = "button, input, a[href], select, textarea, [role=slider], [role=tab], label";
  const PANELS = "[data-dock-region], [data-floating-window], .mantine-Paper-root";

  const overlap = (a, b) =>
    Math.max(0, Math.min(a.right, b.right) - Math.max(a.left, b.left)) *
    Math.max(0, Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top));
  const boxAt = (left, top, { width, height }) => ({ left, top, right: left + width, bottom: top + height });

  const place = (tooltip, target) => {
    const [dx = 0, dy = 0] = (tooltip.style.translate || "0 0").split(" ").map(Number.parseFloat);
    const drawn = tooltip.getBoundingClientRect();
    const own = target.getBoundingClientRect();
    const usual = boxAt(drawn.left - dx, drawn.top - dy, drawn);
    const panel = (target.closest(PANELS) ?? target).getBoundingClientRect();
    const { width, height } = drawn;
    const across = Math.min(Math.max((own.left + own.right - width) / 2, EDGE), innerWidth - EDGE - width);
    const level = Math.min(Math.max((own.top + own.bottom - height) / 2, EDGE), innerHeight - EDGE - height);
    const candidates = [
      usual,
      boxAt(across, own.bottom + GAP, drawn),
      boxAt(across, own.top - GAP - height, drawn),
      boxAt(panel.left - GAP - width, level, drawn),
      boxAt(panel.right + GAP, level, drawn),
      boxAt(across, panel.top - GAP - height, drawn),
      boxAt(across, panel.bottom + GAP, drawn),
    ];
    const others = [...document.querySelectorAll(CONTROLS)]
      .filter((one) => !one.contains(target) && one.checkVisibility())
      .map((one) => one.getBoundingClientRect());
    let best = null;
    for (const box of candidates) {
      const inside = box.left >= 0 && box.top >= 0 && box.right <= innerWidth && box.bottom <= innerHeight;
      const covered = others.reduce((sum, other) => sum + overlap(box, other), 0);
      if (inside && (!best || covered < best.covered)) best = { box, covered };
      if (best?.covered === 0) break;
    }
    const [x, y] = best ? [best.box.left - usual.left, best.box.top - usual.top] : [0, 0];
    if (Math.abs(x - dx) + Math.abs(y - dy) < 1) return;
    tooltip.style.translate = `${x}px ${y}px`;
    // Its arrow would point at another control.
    tooltip.toggleAttribute("data-duet-moved", x !== 0 || y !== 0);
  };

  const boxOf = (one) => {
    const { left, top, width, height } = one.getBoundingClientRect();
    return [left, top, width, height].join();
  };
  const follow = (tooltip, before = "") => {
    if (!tooltip.isConnected) return;
    const target = document.querySelector(`[aria-describedby="${tooltip.id}"]`);
    // A row of buttons without a hint has an empty one.
    tooltip.hidden = !tooltip.textContent;
    const shown = target && !tooltip.hidden;
    // Where nothing moved, the other controls need not be looked at.
    if (shown && `${boxOf(tooltip)} ${boxOf(target)}` !== before) place(tooltip, target);
    const now = shown ? `${boxOf(tooltip)} ${boxOf(target)}` : "";
    requestAnimationFrame(() => follow(tooltip, now));
  };
  new MutationObserver((changes) => {
    for (const { addedNodes } of changes)
      for (const node of addedNodes) {
        if (!(node instanceof Element)) continue;
        const tooltip = node.matches(".mantine-Tooltip-tooltip") ? node : node.querySelector(".mantine-Tooltip-tooltip");
        if (tooltip) follow(tooltip);
      }
  }).observe(document.body, { childList: true, subtree: true });
});
