// Makes the heading of every folder of controls a button with a role, a state, and the keys Enter and Space:
// viser draws it as a box that only a mouse can open.
(() => {
  const heading = ".mantine-Paper-root > .mantine-Paper-root";
  const mend = () => {
    for (const icon of document.querySelectorAll(`${heading} > svg[class*=tabler-icon-chevron]`)) {
      const button = icon.parentElement;
      const open = String(icon.matches(".tabler-icon-chevron-up"));
      if (button.ariaExpanded === open) continue;
      button.setAttribute("role", "button");
      button.tabIndex = 0;
      button.ariaExpanded = open;
      icon.ariaHidden = "true";
    }
  };
  const press = (event) => {
    if ((event.key !== "Enter" && event.key !== " ") || !event.target.matches?.(`${heading}[role=button]`)) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    if (!event.repeat) event.target.click();
  };
  addEventListener("DOMContentLoaded", () =>
    new MutationObserver(mend).observe(document.body, { childList: true, subtree: true }),
  );
  addEventListener("keydown", press, true);
})();
