// React writes the HTML of an element once more whenever a neighbour is added to it. What the page has done there would be lost: a curve that
// is drawn, the focus, a list that is open. So the same HTML is left alone.
(() => {
  const { get, set } = Object.getOwnPropertyDescriptor(Element.prototype, "innerHTML");
  const written = new WeakMap();
  Object.defineProperty(Element.prototype, "innerHTML", {
    configurable: true,
    enumerable: true,
    get,
    set(html) {
      if (html && this.firstChild && written.get(this) === html) return;
      written.set(this, html);
      set.call(this, html);
    },
  });
})();
