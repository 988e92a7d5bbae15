// Lets an element of our own HTML stand for a button of viser's: data-duet-presses is that button's id.
addEventListener("click", ({ target }) => {
  const ours = target instanceof Element && target.closest("[data-duet-presses]");
  if (ours) document.getElementById(ours.dataset.duetPresses)?.click();
});
