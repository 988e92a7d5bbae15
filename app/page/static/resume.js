// Gives every tab a random word of its own, under which the server keeps its progress for a while.
(() => {
  const STORED = "duetResume";
  let word = "";
  try {
    word = sessionStorage.getItem(STORED);
  } catch {
    // The browser blocks storage for this page: the word lives as long as the page.
  }
  if (!word) {
    word = Array.from(crypto.getRandomValues(new Uint8Array(16)), (byte) => byte.toString(16).padStart(2, "0")).join("");
    try {
      sessionStorage.setItem(STORED, word);
    } catch {
      // As above.
    }
  }
  duet.query.resume = word;
})();
