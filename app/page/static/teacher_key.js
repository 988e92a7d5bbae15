// Takes the teacher's key out of the address bar, where a projector shows it and every copied link has it.
// The tab keeps it for when the page is loaded again, until the page says that it is wrong.
(() => {
  const STORED = "duetKey";
  try {
    const url = new URL(location.href);
    const given = url.searchParams.get("key");
    if (given !== null) {
      sessionStorage.setItem(STORED, given);
      url.searchParams.delete("key");
      history.replaceState(history.state, "", url);
    }
    const key = sessionStorage.getItem(STORED);
    if (!key) return;
    duet.query.key = key;
    const timer = setInterval(() => {
      if (!document.querySelector(".duet-key-wrong")) return;
      sessionStorage.removeItem(STORED);
      clearInterval(timer);
    }, 300);
  } catch {
    // The browser blocks storage for this page: the address is the only place for the key.
  }
})();
