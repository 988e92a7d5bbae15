// Writes on an element what it holds, as words of `data-duet-holds`, for the style sheets: with `:has()` they would ask that of the whole
// page after every change, which took half of a running page's processor time.
(() => {
  const window_ = "[data-floating-window]";
  const moments = "[data-duet-span], [data-duet-seek], [data-duet-picture]";
  const above = (levels) => (held) => {
    let element = held;
    for (let i = 0; element && i < levels; i++) element = element.parentElement;
    return element;
  };
  const around = (selector) => (held) => held.closest(selector);
  const besides = (selector) => (held) => held.closest(selector)?.parentElement;
  // Of each word: what is held, and how its holder is found.
  const words = {
    plots: [".duet-plots", around(window_)],
    charts: [`${window_} .uplot-container`, above(2)],
    unseen: [
      `.duet-plots, ${window_} style, .duet-language, .duet-welcome, .duet-panel, [class^=duet-contact-], ${moments}`,
      above(1),
    ],
    overlay: [`${window_} .duet-overlay`, above(1)],
    row: [`${window_} .mantine-Flex-root`, above(1)],
    caption: [".duet-caption", above(1)],
    first: [".duet-first", above(1)],
    spare: [".duet-spare", above(1)],
    label: [".mantine-Flex-root > div > p > label[for]", above(2)],
    "buttons-label": [
      ".mantine-Flex-root > div + div > div > .mantine-Flex-root > .mantine-Button-root:first-child",
      (button) => button.parentElement.parentElement.parentElement.previousElementSibling,
    ],
    lesson: [".duet-lesson", above(2)],
    drawing: [".duet-l-drawing .duet-draw", besides(".duet-l-drawing")],
    "dock-head": [
      "[data-dock-region=right] .tabler-icon-list-search",
      (icon) => icon.closest("button")?.parentElement?.parentElement?.parentElement,
    ],
    "view-row": [".duet-view-row", above(1)],
    heads: [".duet-heads", above(2)],
    welcome: ["#duet-welcome", around(":root")],
    small: [".duet-small", around(":root")],
    "right-dock": ["[data-dock-rail-root] [data-dock-edge=right]", around(":root")],
    "left-dock": ["[data-dock-rail-root] [data-dock-edge=left]", around(":root")],
  };
  // Scripts of features add their words before the page is built.
  duet.holders = { words, above, around };
  let any = "";
  let holders = new Map();

  const write = () => {
    const found = new Map();
    for (const [word, [held, holderOf]] of Object.entries(words)) {
      for (const element of document.querySelectorAll(held)) {
        const holder = holderOf(element);
        if (holder) found.set(holder, (found.get(holder) ?? new Set()).add(word));
      }
    }
    for (const holder of holders.keys()) if (!found.has(holder)) delete holder.dataset.duetHolds;
    for (const [holder, its] of found) {
      const text = [...its].join(" ");
      if (holder.dataset.duetHolds !== text) holder.dataset.duetHolds = text;
    }
    holders = found;
  };
  const matters = (node) => node.nodeType === Node.ELEMENT_NODE && (node.matches(any) || node.querySelector(any));
  addEventListener("DOMContentLoaded", () => {
    any = Object.values(words)
      .map(([held]) => held)
      .join(",");
    // Before the next frame is drawn, so that nothing is seen without its style.
    new MutationObserver((changes) => {
      if (changes.some(({ addedNodes, removedNodes }) => [...addedNodes, ...removedNodes].some(matters))) write();
    }).observe(document.documentElement, { childList: true, subtree: true });
    write();
  });
})();
