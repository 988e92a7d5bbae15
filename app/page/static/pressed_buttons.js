// Lets an element of our own HTML stand for a button of viser's: data-duet-presses is that button's id.
addEventListener("click", ({ target }) => {
  const ours = target instanceof Element && target.closest("[data-duet-presses]");
  if (ours) document.getElementById(ours.dataset.duetPresses)?.click();
});

// A hint says what a button does: once that is pressed, the hint only covers what comes of it, until the pointer has left the button.
(() => {
  let pressed = null;
  const press = (button) => {
    pressed = button;
    document.documentElement.toggleAttribute("data-duet-pressed", button !== null);
  };
  addEventListener("pointerdown", ({ target }) => press(target instanceof Element ? target.closest("button,label") : null), true);
  addEventListener("pointerover", ({ target }) => pressed && !pressed.contains(target) && press(null), true);
})();
