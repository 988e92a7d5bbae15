"""No hint of the first screen covers another control, at three sizes."""

import pytest
from playwright.sync_api import Page

from tests.app.conftest import OpenHouse
from tests.app.page.by_hand import visit
from tests.browser import PageAt, until, wait_frames

TIPPED = ".mantine-Slider-root, .mantine-Input-input, .mantine-Flex-root > .mantine-Button-root"
"""Controls of the first screen with a hint."""

LEAST = 10
"""Least number of such controls."""

COVERED = """() => {
  const tooltip = [...document.querySelectorAll('.mantine-Tooltip-tooltip')].find(one => one.checkVisibility());
  const target = tooltip && document.querySelector(`[aria-describedby="${tooltip.id}"]`);
  if (!target) return null;
  const a = tooltip.getBoundingClientRect();
  const kinds = 'button, input, a[href], select, textarea, [role=slider], [role=tab]';
  const met = [...document.querySelectorAll(kinds)].filter(one => {
    if (target.contains(one) || !one.checkVisibility()) return false;
    const b = one.getBoundingClientRect();
    return b.width && Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1
      && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 1;
  });
  const outside = a.left < 0 || a.top < 0 || a.right > innerWidth || a.bottom > innerHeight;
  return { hint: tooltip.textContent, outside, met: met.map(one => one.getAttribute('aria-label') || one.textContent || one.id) };
}"""
"""The visible hint, and the controls that it covers, except its own."""


NAME = "one => one.getAttribute('aria-label') || one.textContent || one.outerHTML"


def hint(page: Page) -> dict[str, object] | None:
    found: dict[str, object] | None = page.evaluate(COVERED)
    return found


@pytest.mark.parametrize(
    ("width", "height"),
    [(1440, 900), *(pytest.param(*size, marks=pytest.mark.thorough) for size in ((1024, 768), (390, 844)))],
)
def test_no_hint_covers_another_control(house: OpenHouse, page_at: PageAt, width: int, height: int) -> None:
    page, tried = page_at(width, height), 0
    visit(page, house(), "panel=small&autopilot=0")
    page.get_by_role("button", name="All settings").wait_for()
    for control in page.locator(TIPPED).all():
        box = control.bounding_box() if control.is_visible() else None
        # The row of "All settings" has no hint.
        if (
            control.inner_text() == "All settings"
            or box is None
            or box["width"] < 10
            or box["y"] + box["height"] > height
        ):
            continue
        # The scene has no hint.
        page.mouse.move(width / 2, height / 3)
        until(page, lambda: hint(page) is None, "no hint")
        page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        until(page, lambda: hint(page) is not None, f"the hint of {control.evaluate(NAME)}")
        wait_frames(page, 2)
        found = hint(page)
        assert found is not None and found["hint"] and found["met"] == [] and not found["outside"], found
        tried += 1
    assert tried >= LEAST
