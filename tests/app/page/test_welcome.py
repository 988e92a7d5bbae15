"""The welcome: once in a browser, beside the arms, gone at the first drag of an arm."""

import pytest
from playwright.sync_api import Page

from app.i18n.catalogue import words_of
from app.page.panels.welcome import is_for_newcomers
from app.settings import Language, Settings
from scenes.settings import changed
from tests.app.conftest import Arrive, Join, OpenHouse
from tests.app.page.by_hand import FREE, WRIST, grab, visit
from tests.app.page.helpers import open_lessons, shown
from tests.browser import PageAt, screenshot, settled_view, until, wait_frames

CARD = "#duet-welcome"
STILL = changed(Settings(), "autopilot", False)
"""An arm that stands still can be taken by the mouse."""

WORDS = {
    "en": "Pull the orange arm into it.",
    "de": "Ziehen Sie den orangen Arm in ihn hinein.",
    "sl": "Potegnite oranžnega robota vanj.",
}


def comes_not(page: Page) -> None:
    """Check that a page which the server would greet with does not show the card."""
    page.locator(".duet-welcome").wait_for(state="attached")
    page.wait_for_function("performance.now() > 2000 && document.documentElement.matches('.duet-built')")
    wait_frames(page, 10)
    assert page.locator(CARD).count() == 0


@pytest.mark.parametrize(
    ("width", "height", "language", "look", "out"),
    [
        (1440, 900, "en", "theme=light", "Escape"),
        (1024, 768, "de", "theme=dark&profile=projector", "Start lesson 1"),
        (390, 844, "sl", "theme=dark", "Just play"),
    ],
)
def test_it_says_three_lines_hides_no_arm_and_goes_at_a_key_or_button(
    house: OpenHouse, page_at: PageAt, width: int, height: int, language: Language, look: str, out: str
) -> None:
    page = page_at(width, height, newcomer=True)
    if out == "Just play":
        page.add_init_script("Object.defineProperty(window, 'localStorage', { get() { throw new DOMException('blocked'); } })")
    session = visit(page, house(STILL), f"lang={language}&{look}")
    card = page.get_by_role("dialog")
    card.get_by_text(WORDS[language]).wait_for()
    arms = [f"/arms/{arm.name}{WRIST}" for arm in session.simulation.room.arms]
    until(page, lambda: page.evaluate(FREE, arms) == [], "both hands in free sight")

    def fits() -> bool:
        box = card.bounding_box()
        inside = box is not None and box["x"] >= 0.0 and box["x"] + box["width"] <= width and box["y"] + box["height"] <= height
        whole = "card => [card, ...card.querySelectorAll('p, button')].every(e => e.scrollWidth <= e.clientWidth + 1)"
        return inside and card.evaluate(whole)

    until(page, fits, "the whole card in the window")
    # Why it matters, where there is room for it.
    assert card.locator("svg").is_visible() == card.locator(".why").is_visible() == (width > 1280)
    assert page.evaluate("document.activeElement === document.body"), "keys still move the arm"
    screenshot(page, f"welcome-{width}")
    page.keyboard.press("Tab")
    first = card.get_by_role("button").first
    assert first.evaluate("button => button === document.activeElement")
    before = session.settings
    if out == "Escape":
        page.keyboard.press(out)
    else:
        page.get_by_role("button", name=words_of(language)(out)).click()
    card.wait_for(state="detached")
    assert session.held is None
    if out == "Start lesson 1":
        page.locator(".duet-l-head .crumb").get_by_text("Lektion 1").wait_for()
        return
    assert session.settings == before
    page.keyboard.press("ArrowUp")
    until(page, lambda: session.held is not None, "a key that moves the hand")


def test_it_goes_at_the_first_drag_and_never_comes_again(house: OpenHouse, page_at: PageAt) -> None:
    opened = house(STILL)
    page = page_at(1024, 768, newcomer=True)
    session = visit(page, opened)
    page.locator(CARD).wait_for()
    settled_view(page)
    grab(page, f"/arms/right{WRIST.removesuffix('/j7')}", lambda: session.held is not None)
    page.mouse.up()
    page.locator(CARD).wait_for(state="detached")
    again = page.context.new_page()
    visit(again, opened)
    comes_not(again)


def test_links_to_something_and_lectures_do_not_greet(house: OpenHouse, arrive: Arrive, join: Join) -> None:
    private, lecture = house(), house(lecture=True)
    arrive(private).visitor.wait_for(lambda v: "duet-welcome" in shown(v))
    for key, value in {"lesson": "1", "rig": "table", "whole": "1"}.items():
        assert not is_for_newcomers({key: value})
        assert "duet-welcome" not in shown(arrive(private, f"{key}={value}").visitor)
    assert is_for_newcomers({"theme": "dark", "lang": "sl", "resume": "x", "window": "1x1"})
    teacher, student = join(lecture), join(lecture)
    assert "duet-welcome" not in shown(teacher) + shown(student)
    one = arrive(private)
    open_lessons(one.visitor)
    one.visitor.wait_for(lambda v: "Start lesson 1" not in shown(v))
