// Turns keys that viser's command palette has no name for, or that move its camera, into the ones that it listens to.
// duet.pressKey(digit) presses a digit with Alt and Shift, a key that is not pressed by chance.
(() => {
  duet.widgets =
    "input, textarea, select, [contenteditable=true], [role=slider], [role=tab], [role=listbox], [role=combobox], [role=dialog], [role=application]";

  duet.pressKey = (digit) => {
    const key = { key: digit, code: `Digit${digit}`, altKey: true, shiftKey: true, bubbles: true };
    document.documentElement.dispatchEvent(new KeyboardEvent("keydown", key));
  };

  // Of a key that is held down, what steps along comes again and again; all else happens once, and in a shared session what a clicker sends.
  const ONCE = duet.shared ? /^(?![jk]$)([ a-z]|Page(Up|Down))$/i : /^(?![jk]$)[ a-z]$/i;
  // What Tab has led to keeps the keys that it has: Space presses a button, ↑ and ↓ scroll what scrolls. After a click they are the page's.
  let byTab = false;
  let reached = null;
  for (const kind of ["keydown", "pointerdown", "focusin"]) {
    const note = ({ key, target }) => {
      if (kind === "keydown") byTab ||= key === "Tab";
      else if (kind === "focusin") reached = byTab ? target : null;
      else [byTab, reached] = [false, null];
    };
    addEventListener(kind, note, true);
  }
  const keepsKey = ({ key, target }) =>
    target instanceof Element &&
    target === reached &&
    (key === " "
      ? target.matches("button, [role=button]")
      : /^(Arrow(Up|Down)|Page(Up|Down))$/.test(key) && target.matches(".mantine-ScrollArea-viewport"));

  const relay = (event) => {
    if (keepsKey(event)) return event.stopPropagation();
    const shortcut = (event.ctrlKey || event.metaKey || event.altKey) && !event.getModifierState("AltGraph");
    if (shortcut || (event.target instanceof Element && event.target.closest(duet.widgets))) return;
    const held = event.repeat && ONCE.test(event.key);
    const digit = duet.relayedKeys[event.key] || duet.relayedKeys[event.key.toLowerCase()];
    if (!held && !digit) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    if (!held) duet.pressKey(digit);
  };
  addEventListener("keydown", relay, true);
})();
