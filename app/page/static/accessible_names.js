// Names every box and slider after the label of its row, and every button that shows nothing but an icon, for screen readers;
// gives the picture its name, and the parts of the page their roles.
(() => {
  const rowLabel = (element) => {
    for (let parent = element.parentElement, i = 0; parent && i < 8; parent = parent.parentElement, i++) {
      const label = parent.querySelector("label");
      if (label) return label.textContent.trim();
    }
    return "";
  };
  const name = (element, text) => {
    element.dataset.named = "1";
    if (text && element.getAttribute("aria-label") !== text) element.setAttribute("aria-label", text);
  };
  // What has a name already, from its label or from viser, keeps it.
  const isNamed = (element) => !element.dataset.named && (element.getAttribute("aria-label") || element.labels?.length);
  const iconName = (button) => {
    const icon = button.querySelector("svg")?.getAttribute("class") ?? "";
    const known = Object.keys(duet.iconNames).find((part) => icon.includes(part));
    if (known) return duet.iconNames[known];
    return button.closest("[class*=Notification-root]") ? "dismiss this message" : "more";
  };
  const parts = [
    // Of each: which element, or how it is found from one; its role; its name.
    [":root:not(:has(#duet-screen main)) [data-dock-root] > :first-child", "main", duet.partNames.stage],
    [":root:has(#duet-screen main) [data-dock-root] > :first-child", "region", duet.partNames.stage],
    ["canvas[data-engine]", "img", duet.shared ? duet.partNames.stage : duet.partNames.scene],
    ["[data-dock-region=left]", "region", duet.partNames.left],
    ["[data-dock-region=right], .mantine-Paper-root[style*='max-height: 60%']", "region", duet.partNames.right],
    ["[data-floating-window]", "region", duet.partNames.floating],
    [".mantine-Container-root:has(> div > img[alt^='Duet:'])", "banner", ""],
    ["div:has(> img[alt^='Duet:'])", "heading", ""],
  ];
  const nameParts = () => {
    for (const [selector, role, text] of parts) {
      for (const part of document.querySelectorAll(selector)) {
        if (part.getAttribute("role") !== role) part.setAttribute("role", role);
        if (role === "heading") part.ariaLevel = "1";
        if (text) name(part, duet.translate(text));
      }
    }
  };
  const nameAll = () => {
    nameParts();
    // The plots may scroll, and often hold nothing that takes the focus: keys can scroll them all the same.
    for (const part of document.querySelectorAll("[data-floating-window] .mantine-ScrollArea-viewport")) part.tabIndex = 0;
    for (const element of document.querySelectorAll("input:not([type=hidden]), textarea, [role=slider]")) {
      if (!isNamed(element)) name(element, rowLabel(element));
    }
    for (const button of document.querySelectorAll("button")) {
      if (button.textContent.trim() || (!button.dataset.named && button.getAttribute("aria-label"))) continue;
      name(button, button.title || duet.translate(iconName(button)));
    }
  };
  addEventListener("DOMContentLoaded", () => {
    let scheduled = false;
    new MutationObserver(() => {
      if (scheduled) return;
      scheduled = true;
      setTimeout(() => {
        scheduled = false;
        nameAll();
      }, 150);
    }).observe(document.body, { childList: true, subtree: true, characterData: true });
    nameAll();
  });
})();
