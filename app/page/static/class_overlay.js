// Shows what `.duet-overlay` holds over the whole page: inside a panel it could not cover more than the panel.
// A student may close it, by the button or Esc.
addEventListener("DOMContentLoaded", () => {
  const overlay = document.createElement("div");
  overlay.id = "duet-overlay";
  overlay.setAttribute("role", "dialog");
  overlay.setAttribute("aria-label", "From the teacher");
  document.body.append(overlay);
  const close = () => {
    overlay.textContent = "";
  };
  overlay.addEventListener("click", (event) => {
    if (event.target === overlay || event.target.closest("button")) close();
  });
  addEventListener("keydown", (event) => {
    if (event.key === "Escape" && overlay.firstChild) close();
  });
  let shown = "";
  setInterval(() => {
    const sent = document.querySelector(".duet-overlay")?.innerHTML ?? "";
    if (sent === shown) return;
    shown = sent;
    overlay.innerHTML = sent;
  }, 250);
});
