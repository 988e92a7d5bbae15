"""A guess of d on the line of contact selects the answer, in a real browser, and stays during the run."""

from dataclasses import dataclass

import pytest
from playwright.sync_api import Locator, Page

from app.features.lessons.outcomes import asks_for_distance, guessed_answer
from app.features.lessons.progress import Progress, from_json, to_json
from app.features.lessons.session.lesson_session import LessonSession
from app.session.session import Session
from tests.app.conftest import OpenHouse, ask
from tests.app.features.lessons.helpers import our_book
from tests.app.page.by_hand import drag
from tests.browser import PageAt, screenshot, settled_box, until
from tests.tools.lesson_walker import enter

STEPS = {
    f"{lesson.number}.{i}": step for lesson in our_book().lessons for i, step in enumerate(lesson.steps, 1)
}
MARK = "#duet-contact path.guess"


def test_the_steps_that_ask_for_a_distance() -> None:
    assert [name for name, step in STEPS.items() if asks_for_distance(step)] == [
        "5.1",
        "7.2",
        "10.4",
        "12.1",
        "12.5",
    ]


@pytest.mark.parametrize(
    ("step", "distance", "answer"),
    [
        ("5.1", 0.15, 1),
        ("5.1", 0.24, 2),
        ("7.2", -0.03, 2),
        ("10.4", 0.16, 0),
        ("10.4", 0.02, 2),
        ("10.4", 0.1, None),
        ("4.3", 0.1, None),
    ],
)
def test_a_distance_decides_between_the_answers(step: str, distance: float, answer: int | None) -> None:
    assert guessed_answer(STEPS[step], distance) == answer
    assert all(guessed_answer(STEPS[step], wild) is None for wild in (float("nan"), float("inf"), 7.0))


def test_a_guess_is_saved_but_an_invalid_one_is_not() -> None:
    progress = Progress()
    progress.at("smooth", "rest").guess = 0.16
    assert from_json(to_json(progress)).at("smooth", "rest").guess == 0.16
    assert from_json(to_json(progress).replace("0.16", '"0.16"')).at("smooth", "rest").guess is None


@dataclass(frozen=True)
class Guesser:
    """A student on a phone at a question that asks for d."""

    page: Page
    session: Session
    lessons: LessonSession

    @property
    def slider(self) -> Locator:
        return self.page.get_by_role("slider", name="my guess [mm]")

    @property
    def guess(self) -> float:
        return self.lessons.walk.done.guess or 0.0

    def by_keys(self, mm: int) -> None:
        """Move the guess by arrow keys."""
        here = round(float(self.slider.input_value()))
        self.slider.focus()
        for _ in range(abs(here - mm)):
            self.page.keyboard.press("ArrowLeft" if here > mm else "ArrowRight")
        until(self.page, lambda: self.guess == mm / 1000.0, "the guess by keys")


@pytest.fixture(scope="module")
def guesser(lasting_house: OpenHouse, lasting_page_at: PageAt) -> Guesser:
    opened, page = lasting_house(), lasting_page_at(390, 844)
    return Guesser(page, *enter(page, opened, "lesson=5&step=1&theme=light&resume=" + "a" * 32))


@pytest.mark.thorough
def test_on_a_phone_a_lesson_begins_at_its_top(guesser: Guesser) -> None:
    """Must be the first test with this page: the page has just opened."""
    page, head = guesser.page, guesser.page.locator(".duet-l-head")

    def in_view() -> bool:
        box = head.bounding_box()
        return box is not None and box["y"] < 594.0 and box["x"] >= 0.0 and box["x"] + box["width"] <= 391.0

    until(page, in_view, "the lesson in view")
    screenshot(page, "lesson-phone")
    page.get_by_text("Drag ▼ along the axis").wait_for()


@pytest.mark.thorough
@pytest.mark.parametrize(("width", "height"), [(390, 844), (1440, 900)], ids=["phone", "desk"])
def test_a_guess_by_mouse_and_by_keys_chooses_the_answer(guesser: Guesser, width: int, height: int) -> None:
    page, slider = guesser.page, guesser.slider
    page.set_viewport_size({"width": width, "height": height})
    slider.wait_for()
    left, top, wide, _ = settled_box(page, slider)
    low, high = (int(slider.get_attribute(end) or 0) for end in ("min", "max"))

    def at(mm: float) -> float:
        return left + 13.0 + (mm - low) / (high - low) * (wide - 26.0)

    def chosen() -> int | None:
        return guesser.lessons.walk.done.choice

    drag(page, [(at(mm), top + 13.0) for mm in (0.8 * high, 220.0)])
    until(page, lambda: chosen() == 2 and abs(guesser.guess - 0.22) < 0.006, "the nearest answer")
    guesser.by_keys(160)
    until(page, lambda: chosen() == 1, "the answer by keys")

    def marked() -> bool:
        # Redrawn for new words: chart or mark may be missing for a moment.
        chart, mark = page.locator("#duet-contact .chart").bounding_box(), page.locator(MARK).bounding_box()
        if chart is None or mark is None:
            return False
        beside = abs(mark["x"] + mark["width"] / 2.0 - at(160.0)) < 2.0
        return beside and chart["y"] <= mark["y"] < chart["y"] + chart["height"]

    until(page, marked, "the mark at the guess")
    screenshot(page, f"guess-{width}")


@pytest.mark.thorough
def test_a_guess_stays_visible_but_fixed_after_the_run(guesser: Guesser) -> None:
    page, run = guesser.page, guesser.lessons
    guesser.by_keys(160)
    ask(guesser.session, lambda s: s.change("speed", 2.0))
    page.get_by_role("button", name="Run", exact=True).first.click()
    until(page, lambda: run.walk.done.outcome is not None, "the outcome")
    guesser.slider.wait_for(state="hidden")
    page.locator("#duet-contact text.guess").get_by_text("my guess 160").wait_for()
    screenshot(page, "guess-after")
