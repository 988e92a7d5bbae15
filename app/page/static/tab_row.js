// Keeps the tabs of a panel in one row, in any font, size and language: icons and names, else names alone, else icons alone. The names are
// the tabs' tips, and screen readers read them in any case. `data-duet-tabs` on the row says which; what it does is in style.css.
(() => {
  const LEVELS = ["both", "names", "icons"];
  const fits = (row, last) => last.getBoundingClientRect().right <= row.getBoundingClientRect().right + 0.5;

  const fit = (row) => {
    const tabs = row.querySelectorAll("[role=tab]");
    if (!tabs.length || !row.clientWidth) return;
    for (const tab of tabs) {
      const name = tab.textContent.trim();
      if (tab.title !== name) tab.title = name;
    }
    // What has no icon needs its name.
    const levels = [...tabs].every((tab) => tab.querySelector("svg")) ? LEVELS : LEVELS.slice(0, 2);
    for (const level of levels) {
      row.dataset.duetTabs = level;
      if (fits(row, tabs[tabs.length - 1])) break;
    }
  };

  // A tab changes its size with its font, its text and the reader's choice of larger text.
  const sizes = new ResizeObserver((changes) => {
    for (const row of new Set(changes.map(({ target }) => target.closest("[role=tablist]")))) if (row) fit(row);
  });
  // An icon alone keeps its size when its name changes.
  const names = new MutationObserver((changes) => {
    for (const row of new Set(changes.map(({ target }) => target.parentElement?.closest("[role=tablist]")))) if (row) fit(row);
  });
  const parts = "[role=tablist], [role=tab]";
  const watch = (node) => {
    if (node.nodeType !== Node.ELEMENT_NODE) return;
    for (const part of [node, ...node.querySelectorAll(parts)]) {
      if (!part.matches(parts)) continue;
      sizes.observe(part);
      names.observe(part, { characterData: true, subtree: true });
      const row = part.closest("[role=tablist]");
      if (row) fit(row);
    }
  };
  addEventListener("DOMContentLoaded", () => {
    new MutationObserver((changes) => {
      for (const { addedNodes, removedNodes, target } of changes) {
        addedNodes.forEach(watch);
        if (removedNodes.length && target.matches("[role=tablist]")) fit(target);
      }
    }).observe(document.body, { childList: true, subtree: true });
    watch(document.body);
  });
})();
