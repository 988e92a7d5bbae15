// Keeps in this browser how many controls its visitor has asked for, as the server says it; the small panel shows the first tab.
// A list that has got more entries, as its visitor has asked, is opened once more.
(() => {
  let before;
  let opened;
  setInterval(() => {
    const marks = document.querySelector(".duet-panel")?.dataset;
    const panel = marks?.panel;
    if (marks && marks.opens !== opened) {
      opened = marks.opens;
      const list = document.getElementById(opened);
      list?.focus();
      list?.click();
    }
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
