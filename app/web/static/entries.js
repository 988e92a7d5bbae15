// What the visitor enters in a control stands until the server has acted upon it: a value that the server wrote there before is left out.
// With every value the server says how many of this page's messages it had dealt with. A box that has the caret and nothing entered yet
// keeps what it shows while values come one after the other: each would take the selection from under the visitor's hands.
(() => {
  const QUIET_MS = 1000;
  // Of the box with the caret: its control, and the newest value that it does not show.
  let kept = null;
  let missed = null;
  let timer = 0;
  // Whether something is typed there, such as a sign, that is no value yet.
  let typed = false;
  // The last number of a box for numbers: one that is left empty shows it again.
  let number = "";
  const waiting = () => window.__viserMutable?.messageQueue ?? [];
  const show = () => {
    if (missed) waiting().push(missed);
    missed = null;
  };
  const showTheLast = () => {
    if (!missed) return;
    const box = document.activeElement;
    const whole = box?.selectionStart === 0 && box.selectionEnd === box.value?.length;
    show();
    if (!whole) return;
    // Once it is drawn, what was selected is selected again.
    requestAnimationFrame(() =>
      requestAnimationFrame(() => {
        if (kept && document.activeElement === box) box.select();
      }),
    );
  };
  const keep = (message) => {
    if (message.uuid !== kept || !("after" in message) || !("value" in message.updates)) return;
    missed = { ...message, updates: { value: message.updates.value } };
    delete message.updates.value;
    clearTimeout(timer);
    if (!typed) timer = setTimeout(showTheLast, QUIET_MS);
  };
  const controlOf = (box) => {
    for (let parent = box.parentElement, i = 0; parent && i < 8; parent = parent.parentElement, i++) {
      const label = parent.querySelector("label[for]");
      if (label) return label.htmlFor;
    }
    return null;
  };
  const fillEmpty = (box) => {
    if (!box.matches?.("input[inputmode]") || box.value || !number || missed) return;
    // As if it were typed: React keeps what it draws to itself.
    Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set.call(box, number);
    box.dispatchEvent(new Event("input", { bubbles: true }));
  };
  const leave = () => {
    show();
    kept = null;
    typed = false;
  };
  addEventListener("focusin", ({ target }) => {
    leave();
    number = target.value ?? "";
    if (!target.matches?.("input[type=text],textarea") || target.closest(".duet-law")) return;
    kept = controlOf(target);
    waiting().forEach(keep);
  });
  addEventListener("focusout", ({ target }) => {
    fillEmpty(target);
    leave();
  });
  addEventListener("input", ({ target }) => {
    typed = true;
    number = target.value || number;
    clearTimeout(timer);
  });

  const Native = window.Worker;
  window.Worker = class extends Native {
    #sent = 0;
    #entered = new Map();

    constructor(...given) {
      super(...given);
      // Comes before viser's own listener, which reads the same object.
      this.addEventListener("message", ({ data }) => this.#receive(data));
    }

    #receive(data) {
      if (data?.type === "connected") {
        this.#sent = 0;
        this.#entered.clear();
      }
      if (data?.type !== "message_batch") return;
      for (const message of data.messages) {
        if (message.after < this.#entered.get(message.uuid)) delete message.updates.value;
        keep(message);
      }
    }

    #enter(uuid) {
      this.#entered.set(uuid, this.#sent);
      if (uuid === kept) kept = missed = null;
      // viser draws what has come at the next picture.
      for (const message of waiting()) if (message.uuid === uuid && "after" in message) delete message.updates.value;
    }

    postMessage(message, ...rest) {
      if (message?.type === "send") {
        this.#sent += 1;
        if (message.message.type === "GuiUpdateMessage") this.#enter(message.message.uuid);
      }
      super.postMessage(message, ...rest);
    }
  };
})();
