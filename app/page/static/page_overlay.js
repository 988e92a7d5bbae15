// Shows what `.duet-overlay` holds over the whole page: inside a panel it could not cover more than the panel.
// The button or Esc closes it: on a page with the key for all pages, by the key 9, on another page there.
addEventListener("DOMContentLoaded", () => {
  const overlay = document.createElement("div");
  overlay.id = "duet-overlay";
  overlay.setAttribute("role", "dialog");
  document.body.append(overlay);
  const close = () => {
    // What waits for somebody has no button.
    if (!overlay.querySelector("button")) return;
    overlay.textContent = "";
    // With the key it is taken away for all.
    closed = !duet.query.key;
    duet.pressKey("9");
  };
  overlay.addEventListener("click", (event) => {
    if (event.target === overlay || event.target.closest("button")) close();
  });
  addEventListener("keydown", (event) => {
    if (event.key === "Escape" && overlay.firstChild) close();
  });
  let shown = null;
  let closed = false;
  setInterval(() => {
    // The element itself says whether it was sent again: the same address may have been away between two looks.
    const sent = document.querySelector(".duet-overlay");
    if (sent === shown) return;
    shown = sent;
    // What was closed stays so, in whichever panel it is found and whoever joins, until it is taken away.
    closed &&= sent !== null && sent.querySelector("button") !== null;
    if (closed) return;
    const focused = overlay.contains(document.activeElement);
    overlay.setAttribute("aria-label", sent?.dataset.label ?? "");
    overlay.innerHTML = sent?.innerHTML ?? "";
    if (focused) overlay.querySelector("button")?.focus();
  }, 250);
});
