// Translates what the browser says by itself: texts of viser's client and of our scripts, wherever they appear on the page.
// duet.translate(text) gives an English text of the list, or a number, in the page's language; duet.decimal(text) replaces the decimal
// signs of all numbers in a text; duet.setLanguage(language) changes that language.
(() => {
  const tables = duet.translations;
  const known = tables.pseudo;
  const asked = new URLSearchParams(location.search).get("lang");
  const preferred = () =>
    (navigator.languages || []).map((l) => l.slice(0, 2).toLowerCase()).find((l) => l === "en" || tables[l]);
  const given = document.documentElement.dataset.words || asked;
  let current = given === "en" || tables[given] ? given : preferred() || "en";
  if (current !== "pseudo") document.documentElement.lang = current;
  // Texts with a {name}, for which anything may stand: key, begin, end.
  const patterns = Object.keys(known)
    .filter((key) => key.includes("{name}"))
    .map((key) => [key, ...key.split("{name}")]);

  duet.decimal = (text) => {
    const sign = tables[current]?.["decimal sign\u0004."] ?? ".";
    return sign === "." ? text : text.replace(/(?<=\d)\.(?=\d|$)/g, sign);
  };
  duet.translate = (english) => {
    const table = tables[current];
    if (!table) return english;
    // The ends of a slider.
    if (/^-?\d+\.\d+$/.test(english)) return duet.decimal(english);
    if (known[english]) return table[english];
    const fits = ([, a, b]) => english.startsWith(a) && english.endsWith(b) && english.length > a.length + b.length;
    const found = patterns.find(fits);
    if (!found) return english;
    const [key, begin, end] = found;
    return table[key].replace("{name}", () => english.slice(begin.length, english.length - end.length));
  };

  // The English text of everything that was translated: another language begins with that, not with our translation.
  const originals = new WeakMap();
  const translate = (node, key, present, put) => {
    const text = present.trim();
    if (!text) return;
    const kept = originals.get(node) || {};
    const same = kept[key] && kept[key].said === text;
    const english = same ? kept[key].english : text;
    const said = duet.translate(english);
    if (said === text || (said === english && !same)) return;
    kept[key] = { english, said };
    originals.set(node, kept);
    put(present.replace(text, () => said));
  };

  const names = ["aria-label", "placeholder", "title"];
  // What the server has sent is in the page's language already.
  const isOurs = (element) => element.closest?.(".duet, script, style, svg[data-duet]");
  const translateAttribute = (element, name) => {
    const value = element.getAttribute(name);
    if (value) translate(element, name, value, (text) => element.setAttribute(name, text));
  };
  const translateText = (node) => {
    if (!node.parentElement || isOurs(node.parentElement)) return;
    translate(node, "text", node.data, (text) => {
      node.data = text;
    });
  };
  const translateTree = (node) => {
    if (node.nodeType === Node.TEXT_NODE) translateText(node);
    if (node.nodeType !== Node.ELEMENT_NODE || isOurs(node)) return;
    for (const name of names) translateAttribute(node, name);
    for (const child of node.childNodes) translateTree(child);
  };

  duet.setLanguage = (language) => {
    if (language === current) return;
    current = language;
    translateTree(document.body);
    dispatchEvent(new Event("duet-language"));
  };

  addEventListener("DOMContentLoaded", () => {
    translateTree(document.body);
    new MutationObserver((changes) => {
      for (const change of changes) {
        if (change.type === "childList") change.addedNodes.forEach(translateTree);
        else if (change.type === "characterData") translateTree(change.target);
        else if (!isOurs(change.target)) translateAttribute(change.target, change.attributeName);
      }
    }).observe(document.body, { childList: true, subtree: true, characterData: true, attributes: true, attributeFilter: names });
  });
})();
