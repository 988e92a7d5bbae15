// Hides viser's page until our controls are there: before, it has its own panel only, with the server's address, which is folded away then.
// connection.js waits again by duet.waitForControls() after a lost connection.
(() => {
  const TITLE_MS = 1000;
  const root = document.documentElement;
  const find = (what) => document.querySelector(`#root ${what}`);
  const isSeen = (part) => part !== null && (part.id === "root" || (part.offsetHeight > 0 && isSeen(part.parentElement)));
  let timer = 0;

  duet.waitForControls = () => {
    const before = find(".duet");
    let titled = 0;
    root.classList.remove("duet-built");
    clearInterval(timer);
    timer = setInterval(() => {
      titled ||= find('img[alt^="Duet:"]') && performance.now();
      const now = find(".duet");
      const built = now && now !== before && !isSeen(find('input[value^="ws"]'));
      // What is in a folded panel is not on the page: then the title is all there is to wait for.
      if (!built && !(titled && performance.now() - titled > TITLE_MS)) return;
      clearInterval(timer);
      root.classList.add("duet-built");
      dispatchEvent(new Event("duet-built"));
    }, 50);
  };

  // Called by loading.html, before viser's program has arrived.
  duet.showLoading = () => {
    const { theme, language, text } = duet.loading;
    const asked = new URLSearchParams(location.search);
    root.classList.toggle("duet-dark", (asked.get("theme") ?? theme) === "dark");
    if (!asked.has("lang") && language !== "auto") duet.setLanguage(language);
    document.querySelector("#duet-loading p").textContent = duet.translate(text);
    duet.waitForControls();
  };
})();
