"""A drawn curve in a real browser: by mouse, finger and keys; after a reload; with the run; as the law."""

import json
from dataclasses import dataclass

import pytest
from playwright.sync_api import Locator, Page, ViewportSize

from app.features.lessons.bookmark import Phase
from app.features.lessons.session.lesson_actions import Press
from app.features.lessons.session.lesson_session import LessonSession
from app.plots.curve_chart import COLUMNS
from app.session.session import Session
from app.start import App
from controllers.curve import curve_through
from tests.app.conftest import OpenHouse, ask, private_of, visitor_of
from tests.app.features.lessons.helpers import lessons_of
from tests.app.page.by_hand import drag, drag_by_finger
from tests.browser import PageAt, close_software_note, screenshot, settled_box, until
from tests.tools.lesson_walker import enter

pytestmark = pytest.mark.thorough

Point = tuple[float, float]


def on_the_board(page: Page, points: tuple[Point, ...]) -> list[Point]:
    """Page positions of points on the axes (coordinates from 0 to 1)."""
    board = page.locator(".duet-draw")
    board.scroll_into_view_if_needed()
    left, top, wide, high = settled_box(page, board.locator(".paper"))
    return [(left + x * wide, top + (1.0 - height) * high) for x, height in points]


def by_mouse(page: Page, *points: Point) -> None:
    drag(page, on_the_board(page, points))


def near(curve: tuple[float | None, ...], expected: float, columns: slice) -> bool:
    return len(curve) == COLUMNS and all(v is not None and abs(v - expected) < 0.03 for v in curve[columns])


@dataclass(frozen=True)
class Drawer:
    """A student at a step that asks for a curve."""

    page: Page
    opened: App

    @property
    def session(self) -> Session:
        return visitor_of(self.opened).session

    @property
    def lessons(self) -> LessonSession:
        return lessons_of(visitor_of(self.opened))

    @property
    def board(self) -> Locator:
        return self.page.get_by_role("application", name="Draw λ over distance d.")

    def drawn(self) -> tuple[float | None, ...]:
        return ask(self.session, lambda _: self.lessons.walk.done.drawing)

    def phase(self) -> Phase:
        return ask(self.session, lambda _: self.lessons.walk.phase)

    def wait_pencil(self) -> None:
        """Wait until a curve is on the board."""
        pencil = self.page.locator(".duet-draw .pencil")
        pencil.wait_for(state="attached")
        until(self.page, lambda: pencil.evaluate("path => path.getTotalLength()") > 40, "a drawn curve")


SIZE: ViewportSize = {"width": 1000, "height": 760}


@pytest.fixture(scope="module")
def shared_drawer(lasting_house: OpenHouse, lasting_page_at: PageAt) -> Drawer:
    opened, page = lasting_house(), lasting_page_at(SIZE["width"], SIZE["height"], fresh=True)
    enter(page, opened, "lesson=4&step=2")
    return Drawer(page, opened)


@pytest.fixture
def drawer(shared_drawer: Drawer) -> Drawer:
    """Student at the beginning of the step."""
    one = shared_drawer
    one.page.set_viewport_size(SIZE)

    def begin(_: Session) -> None:
        one.lessons.enter("lambda", 1)
        one.lessons.act(Press("reset"))

    ask(one.session, begin)
    one.board.wait_for()
    until(one.page, lambda: one.drawn() == () and one.phase() is Phase.PREDICT, "an empty board")
    return one


def test_a_curve_is_drawn_by_mouse_keys_and_finger(drawer: Drawer) -> None:
    page, drawn = drawer.page, drawer.drawn
    assert page.locator(".duet-chart").count() == 0, "the live curve would show the answer"
    by_mouse(page, (0.0, 0.9), (1.0, 0.9))
    until(page, lambda: near(drawn(), 0.9, slice(0, COLUMNS)), "drawn by mouse")
    assert drawer.phase() is Phase.PREDICT
    page.get_by_role("button", name="Clear").click()
    until(page, lambda: drawn() == (), "cleared")
    drawer.board.focus()
    for key in ("Home", "PageUp", *("ArrowRight",) * 4, *("ArrowDown",) * 3):
        page.keyboard.press(key)
    page.get_by_text("d = 73.4 mm, λ = 0.54").wait_for()
    until(page, lambda: near(drawn(), 0.6, slice(0, 1)) and near(drawn(), 0.54, slice(4, 5)), "drawn by keys")
    assert near(drawn(), 0.57, slice(2, 3)) and drawn()[5] is None, (
        "the skipped columns are on a straight line"
    )
    assert drawer.phase() is Phase.PREDICT, "the board takes the arrow keys, not the lesson"
    by_mouse(page, (1.0, 0.8), (0.0, 0.8))
    until(page, lambda: near(drawn(), 0.8, slice(0, COLUMNS)), "drawn backwards")
    drag_by_finger(page, on_the_board(page, ((0.51, 0.1), (0.7, 0.1), (1.0, 0.1))))
    until(page, lambda: near(drawn(), 0.1, slice(25, COLUMNS)), "drawn over by a finger")
    assert near(drawn(), 0.8, slice(0, 23))
    screenshot(page, "drawing")


def test_a_curve_survives_a_reload_gets_the_run_over_it_and_moves_the_arm(drawer: Drawer) -> None:
    page = drawer.page
    by_mouse(page, (0.0, 0.8), (0.5, 0.8), (1.0, 0.1))
    until(page, lambda: near(drawer.drawn(), 0.8, slice(0, COLUMNS // 2 - 2)), "drawn")
    page.reload()
    drawer.wait_pencil()
    close_software_note(page)
    until(
        page, lambda: len(private_of(drawer.opened).visitors) == 1, "the session of the page that came again"
    )
    # Slow, so that the run does not end before it is skipped.
    ask(drawer.session, lambda s: s.change("speed", 0.25))
    page.get_by_role("button", name="Run", exact=True).click()
    page.locator(".duet-l-said figure").wait_for()
    page.locator(".duet-draw").wait_for(state="detached")
    page.get_by_role("button", name="Skip the run").click()
    verdict, said = page.locator(".duet-l-verdict"), page.locator("#duet-say")
    verdict.get_by_text("Your curve is off by 0.", exact=False).wait_for()
    assert verdict.get_by_text("by the formula").count() == 1 and verdict.locator("path.lam").count() >= 1
    until(page, lambda: "Your curve is off by" in (said.text_content() or ""), "read out")
    assert "250" not in (said.text_content() or "").split(), "the numbers of the axes are not read out"
    page.locator(".duet-chart").wait_for()
    screenshot(page, "drawing-verdict")

    def law() -> str:
        return ask(drawer.session, lambda one: one.settings.run.law.law)

    page.get_by_role("button", name="Run with my curve").click()
    until(page, lambda: law() == "drawn_curve", "the arm obeys it")
    page.get_by_text("Your curve at work: ").first.wait_for()
    page.get_by_role("button", name="Back to the outcome").click()
    until(page, lambda: law() == "smooth_priority", "back")


def test_outside_the_lessons_a_drawn_or_typed_curve_moves_the_arm(drawer: Drawer) -> None:
    page, session = drawer.page, drawer.session
    page.get_by_role("button", name="Leave the lessons").click()
    page.get_by_role("tab", name="Law").wait_for()
    page.set_viewport_size({"width": 1440, "height": 900})
    ask(session, lambda s: [s.change("scene", "ball"), s.change("law", "drawn_curve")])

    def curve() -> str:
        return ask(session, lambda one: one.settings.run.law.curve)

    drawer.board.scroll_into_view_if_needed()
    drawer.wait_pencil()
    by_mouse(page, (0.0, 1.0), (0.5, 1.0), (1.0, 0.0))
    until(page, lambda: curve() != "0.15:1,0.2:0.3,0.4:0", "drawn by mouse")
    drawn = curve_through(curve())
    assert drawn.height(0.1) > 0.95 and abs(drawn.height(0.3) - 0.5) < 0.08 and drawn.height(0.4) < 0.08
    assert len(drawn.heights) < 12
    assert ask(session, lambda one: one.simulation.law.activation(0.3)) == drawn.height(0.3)
    screenshot(page, "drawn-curve")

    box, alert = page.get_by_role("textbox", name="λ(d)"), page.get_by_role("alert")
    box.fill("0.1:1,0.2")
    alert.get_by_text("cannot be read").wait_for()
    box.fill("0.1:1,0.20:0")
    until(page, lambda: curve() == "0.1:1,0.2:0", "typed")
    alert.wait_for(state="hidden")
    assert box.input_value() == "0.1:1,0.20:0", "the typed text is not rewritten"

    def heights() -> list[float]:
        return json.loads(page.locator(".duet-draw").get_attribute("data-curve") or "[]")

    until(page, lambda: heights()[:2] == [1, 1] and heights()[-1] == 0, "the board follows")
