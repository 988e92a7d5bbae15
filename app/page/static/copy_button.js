// The buttons that copy the text beside them: to the clipboard where the page may, by selecting it where it may not (plain http).
(() => {
  const DONE_MS = 2500;
  const copy = async (button) => {
    const source = button.parentElement.querySelector(button.dataset.copies);
    // It stays selected, so that it can be copied by hand.
    const select = () => (source.select ? source.select() : getSelection().selectAllChildren(source));
    const done = () => {
      button.textContent = button.dataset.done;
      setTimeout(() => {
        button.textContent = button.dataset.label;
      }, DONE_MS);
    };
    select();
    try {
      await navigator.clipboard.writeText(source.value ?? source.textContent);
      done();
    } catch {
      select();
      if (document.execCommand("copy")) done();
    }
  };
  const onClick = ({ target }) => {
    const button = target instanceof Element && target.closest(".duet-copy");
    if (button) copy(button);
  };
  addEventListener("click", onClick, true);
})();
