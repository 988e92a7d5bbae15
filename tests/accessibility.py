"""Accessibility of a page: axe finds no fault, and no letter is smaller than 11 px."""

from importlib.resources import files

from playwright.sync_api import Page

from tests.browser import lasting

AXE = (files("axe_playwright_python") / "axe.min.js").read_text(encoding="utf-8")

LEFT_OUT = {
    "aria-required-children": "viser's bar of folded tabs holds the button that unfolds them, and we cannot take it out of there"
}
"""Rule of axe → reason why our pages may break it."""

SMALLEST = 11.0
"""Smallest letter [CSS px]."""

FAULTS = """async ([leftOut, smallest]) => {
  const rules = Object.fromEntries(leftOut.map((rule) => [rule, { enabled: false }]));
  const { violations } = await axe.run(document, { resultTypes: ["violations"], rules });
  const faults = violations.flatMap(({ id, nodes }) => nodes.map((node) =>
    `${id}: ${node.target.join(" ")} ${node.html.slice(0, 120)} ${[...node.any, ...node.all, ...node.none][0]?.message ?? ""}`));
  const words = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT), range = document.createRange();
  for (let text; text = words.nextNode();) {
    const element = text.parentElement, style = getComputedStyle(element);
    if (!text.data.trim() || !element.checkVisibility({ visibilityProperty: true })) continue;
    range.selectNodeContents(text);
    if (range.getBoundingClientRect().width < 2) continue;
    // A drawing may be smaller than its own units.
    const scale = element.closest("svg")?.getScreenCTM()?.d ?? 1;
    const size = parseFloat(style.fontSize) * scale;
    if (size < smallest - 0.1) faults.push(`${size.toFixed(1)} px: ${text.data.trim().slice(0, 40)} in ${element.outerHTML.slice(0, 90)}`);
  }
  return faults;
}"""


def accessible(page: Page) -> None:
    """Assert that a page has no lasting fault."""
    page.evaluate(AXE)
    # A tooltip, which is shown while the mouse rests on its element, is in no landmark.
    page.mouse.move(1.0, 1.0)
    faults = lasting(page, lambda: page.evaluate(FAULTS, [list(LEFT_OUT), SMALLEST]))
    assert not faults, f"{len(faults)} faults:\n" + "\n".join(faults[:30])
