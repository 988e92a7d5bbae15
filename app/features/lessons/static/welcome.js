// Shows the card of `.duet-welcome` over the 3-D view, until the visitor closes it or the server says that it is over; then never again in
// this browser.
addEventListener("DOMContentLoaded", () => {
  const STORED = "duetWelcome";
  try {
    if (localStorage.getItem(STORED)) return;
  } catch {
    // The browser blocks storage for this page: the card comes once a page.
  }
  const card = document.createElement("section");
  card.id = "duet-welcome";
  card.setAttribute("role", "dialog");
  let shown = "";
  let timer = 0;
  const end = () => {
    clearInterval(timer);
    removeEventListener("keydown", onKey);
    card.remove();
    try {
      localStorage.setItem(STORED, "1");
    } catch {
      // As above.
    }
  };
  const onKey = (event) => {
    if (event.key === "Escape" && card.isConnected) end();
  };
  addEventListener("keydown", onKey);
  card.addEventListener("click", ({ target }) => {
    if (target.closest("button")) end();
  });
  timer = setInterval(() => {
    const sent = document.querySelector(".duet-welcome");
    if (!sent || !document.documentElement.matches(".duet-built")) return;
    if (sent.dataset.over) {
      end();
      return;
    }
    if (sent.innerHTML === shown) return;
    shown = sent.innerHTML;
    card.innerHTML = shown;
    card.setAttribute("aria-label", sent.getAttribute("aria-label"));
    // First in the order of the Tab key. It takes no focus: keys go on moving the arm.
    if (!card.isConnected) document.body.prepend(card);
  }, 250);
});
