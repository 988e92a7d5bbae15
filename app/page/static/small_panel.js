// Keeps in this browser how many controls its visitor has asked for, as the server says it; the small panel shows the first tab.
(() => {
  let before;
  setInterval(() => {
    const panel = document.querySelector(".duet-panel")?.dataset.panel;
    if (panel === undefined || panel === before) return;
    if (before !== undefined) {
      try {
        localStorage.setItem("duetPanel", panel);
      } catch {
        // It is small again the next time.
      }
    }
    before = panel;
    if (panel === "small") document.querySelector("[data-dock-region=right] [role=tab], .mantine-Tabs-tab")?.click();
  }, 250);
})();
