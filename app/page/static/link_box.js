// Selects the whole link when its box gets the focus.
addEventListener("focusin", ({ target }) => {
  if (target instanceof HTMLInputElement && target.matches(".duet-link input")) target.select();
});
