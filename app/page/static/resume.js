// Gives every tab a random word of its own, under which the server keeps its progress for a while. In a shared session the word of one
// without the key is the browser's, so that who closes the tab and opens another one is the same person there.
(() => {
  const STORED = "duetResume";
  const isWatcher = duet.shared && !duet.query.key && !new URLSearchParams(location.search).has("screen");
  let storage = null;
  let word = "";
  try {
    storage = isWatcher ? localStorage : sessionStorage;
    word = storage.getItem(STORED);
  } catch {
    // The browser blocks storage for this page: the word lives as long as the page.
  }
  if (!word) {
    word = Array.from(crypto.getRandomValues(new Uint8Array(16)), (byte) => byte.toString(16).padStart(2, "0")).join("");
    try {
      storage?.setItem(STORED, word);
    } catch {
      // As above.
    }
  }
  duet.query.resume = word;
})();
