// Gives the numbers that viser's client writes, in its boxes and at the axes of its plots, the decimal sign of the page's language.
// The ends of its sliders are text, which `translation.js` translates.
(() => {
  // The plots would write their axes in the browser's language, which need not be the page's.
  Object.defineProperty(navigator, "language", { value: "en", configurable: true });
  const fillText = CanvasRenderingContext2D.prototype.fillText;
  CanvasRenderingContext2D.prototype.fillText = function (text, ...where) {
    fillText.call(this, this.canvas.closest(".uplot") ? duet.decimal(String(text)) : text, ...where);
  };

  // The client reads and sets numbers with a point; the visitor sees and types them with a comma.
  const value = Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value");
  const isNumber = (box) => box.classList.contains("mantine-NumberInput-input");
  Object.defineProperty(HTMLInputElement.prototype, "value", {
    ...value,
    get() {
      const seen = value.get.call(this);
      return isNumber(this) ? seen.replace(",", ".") : seen;
    },
    set(given) {
      value.set.call(this, isNumber(this) ? duet.decimal(String(given)) : given);
    },
  });
  const write = (box) => {
    const number = box.value;
    box.value = number;
  };
  // A point that was typed, and what stood there in another language.
  addEventListener("focusout", ({ target }) => target instanceof HTMLInputElement && isNumber(target) && write(target));
  addEventListener("duet-language", () => document.querySelectorAll(".mantine-NumberInput-input").forEach(write));
})();
