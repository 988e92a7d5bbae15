"""An arm is drawn once all of its links are loaded, including the hand."""

from playwright.sync_api import Page

from app.stage.arms import SHAPE
from tests.app.conftest import OpenHouse
from tests.app.page.by_hand import WRIST, visit
from tests.browser import PageAt, until

WATCH = f"""(() => {{
  const seen = window.duetArms = {{ drawn: 0, early: 0 }}, watched = new WeakSet();
  const nodes = () => window.__viserMutable?.nodeRefFromName ?? {{}}, links = {WRIST!r}.split('/').slice(1);
  const shapes = (arm) => links.map((_, i) => nodes()[`${{arm}}/${{links.slice(0, i + 1).join('/')}}/{SHAPE}`]);
  const look = () => {{
    for (const arm of ['/arms/left', '/arms/right']) nodes()[`${{arm}}/base`]?.traverse((mesh) => {{
      if (!mesh.isMesh || watched.has(mesh)) return;
      watched.add(mesh);
      mesh.onAfterRender = () => {{ seen[shapes(arm).every(Boolean) ? 'drawn' : 'early'] += 1; }};
    }});
    requestAnimationFrame(look);
  }};
  requestAnimationFrame(look);
}})()"""
"""Counts how often a part of an arm is drawn with all of its links, and without."""


def seen(page: Page) -> dict[str, int]:
    found: dict[str, int] = page.evaluate("window.duetArms")
    return found


def test_no_part_of_an_arm_is_drawn_before_its_hand(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(1024, 768)
    page.add_init_script(WATCH)
    visit(page, house(), "panel=small")
    until(page, lambda: seen(page)["drawn"] > 50, "the arms")
    assert seen(page)["early"] == 0, seen(page)
    base, others = "__viserMutable.nodeRefFromName['/arms/right/base'].visible", "/arms/left/base"
    for link in (WRIST, "/base/j1/j2", "/base"):
        shape = f"/arms/right{link}/{SHAPE}"
        # A mesh that viser does not have counts as not loaded.
        page.evaluate(
            "name => { const all = __viserMutable.nodeRefFromName; window.kept = all[name]; delete all[name]; }",
            shape,
        )
        until(page, lambda: not page.evaluate(base), f"nothing of an arm without {shape}")
        assert page.evaluate("name => __viserMutable.nodeRefFromName[name].visible", others)
        page.evaluate("name => { __viserMutable.nodeRefFromName[name] = window.kept; }", shape)
        until(page, lambda: page.evaluate(base), "the whole arm")
    assert seen(page)["early"] == 0, seen(page)
