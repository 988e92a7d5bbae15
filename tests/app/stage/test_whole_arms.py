"""An arm is drawn once all of its links are loaded, its hand with it."""

from playwright.sync_api import Page

from tests.app.conftest import OpenHouse
from tests.app.page.by_hand import WRIST, visit
from tests.browser import PageAt, until

WATCH = f"""(() => {{
  const seen = window.duetArms = {{ drawn: 0, early: 0, late: 0 }}, watched = new WeakSet();
  const nodes = () => window.__viserMutable?.nodeRefFromName ?? {{}};
  const look = () => {{
    for (const arm of ['/arms/left', '/arms/right']) nodes()[`${{arm}}/base`]?.traverse((mesh) => {{
      if (!mesh.isMesh || watched.has(mesh)) return;
      watched.add(mesh);
      const whole = () => Boolean(nodes()[arm + {WRIST!r}]);
      if (!whole()) seen.late += 1;
      mesh.onAfterRender = () => {{ seen[whole() ? 'drawn' : 'early'] += 1; }};
    }});
    requestAnimationFrame(look);
  }};
  requestAnimationFrame(look);
}})()"""
"""Count how often a part of an arm is drawn with its last link and without, and the parts that were there before that link."""


def seen(page: Page) -> dict[str, int]:
    found: dict[str, int] = page.evaluate("window.duetArms")
    return found


def test_no_part_of_an_arm_is_drawn_before_its_hand(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(1024, 768)
    page.add_init_script(WATCH)
    visit(page, house(), "panel=small")
    until(page, lambda: seen(page)["drawn"] > 50, "the arms")
    assert seen(page)["late"] > 0 and seen(page)["early"] == 0, seen(page)
