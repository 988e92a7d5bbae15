// Turns keys that viser's command palette has no name for, or that move its camera, into the ones that it listens to.
// duet.pressKey(digit) presses a digit with Alt and Shift, a key that is not pressed by chance.
(() => {
  duet.widgets =
    "input, textarea, select, [contenteditable=true], [role=slider], [role=tab], [role=listbox], [role=combobox], [role=dialog], [role=application]";

  duet.pressKey = (digit) => {
    const key = { key: digit, code: `Digit${digit}`, altKey: true, shiftKey: true, bubbles: true };
    document.documentElement.dispatchEvent(new KeyboardEvent("keydown", key));
  };

  const relay = (event) => {
    const digit = duet.relayedKeys[event.key] || duet.relayedKeys[event.key.toLowerCase()];
    const shortcut = (event.ctrlKey || event.metaKey || event.altKey) && !event.getModifierState("AltGraph");
    if (!digit || shortcut) return;
    if (event.target instanceof Element && event.target.closest(duet.widgets)) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    duet.pressKey(digit);
  };
  addEventListener("keydown", relay, true);
})();
