"""A guess of d on the line of contact: by mouse and keys, it chooses the answer, stays through the run, and survives a reload."""

import pytest

from app.lessons.outcomes import asks_for_distance, guessed_answer
from app.lessons.progress import Progress, from_json, to_json
from tests.app.conftest import OpenHouse, ask
from tests.app.lessons.helpers import our_book
from tests.app.page.by_hand import drag
from tests.browser import PageAt, screenshot, settled_box, until
from tests.tools.lesson_walker import enter

STEPS = {f"{lesson.number}.{i}": step for lesson in our_book().lessons for i, step in enumerate(lesson.steps, 1)}
MARK = "#duet-contact path.guess"


def test_the_steps_that_ask_for_a_distance() -> None:
    assert [name for name, step in STEPS.items() if asks_for_distance(step)] == ["5.1", "7.2", "10.4"]


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


def test_a_guess_is_kept_and_a_wild_one_is_not() -> None:
    progress = Progress()
    progress.at("smooth", "rest").guess = 0.16
    assert from_json(to_json(progress)).at("smooth", "rest").guess == 0.16
    assert from_json(to_json(progress).replace("0.16", '"0.16"')).at("smooth", "rest").guess is None


def test_a_guess_on_the_axis(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(390, 844)
    session, run = enter(page, house(), "lesson=5&step=1&theme=light&resume=" + "a" * 32)
    head = page.locator(".duet-l-head")

    def in_view() -> bool:
        box = head.bounding_box()
        return box is not None and box["y"] < 594.0 and box["x"] >= 0.0 and box["x"] + box["width"] <= 391.0

    until(page, in_view, "on a phone a lesson begins at its top")
    screenshot(page, "lesson-phone")
    slider = page.get_by_role("slider", name="my guess [mm]")
    slider.wait_for()
    page.get_by_text("Drag ▼ along the axis").wait_for()
    for width, height in ((390, 844), (1440, 900)):
        page.set_viewport_size({"width": width, "height": height})
        left, top, wide, _ = settled_box(page, slider)
        low, high = (int(slider.get_attribute(end) or 0) for end in ("min", "max"))

        def at(mm: float, left: float = left, wide: float = wide, low: int = low, high: int = high) -> float:
            return left + 13.0 + (mm - low) / (high - low) * (wide - 26.0)

        drag(page, [(at(mm), top + 13.0) for mm in (0.8 * high, 220.0)])
        until(page, lambda: run.walk.done.choice == 2 and abs((run.walk.done.guess or 0.0) - 0.22) < 0.006, "the nearest answer")
        guess = run.walk.done.guess
        assert guess is not None
        # By keys, to another answer.
        slider.focus()
        for _ in range(round(1000.0 * guess) - 160):
            page.keyboard.press("ArrowLeft")
        until(page, lambda: run.walk.done.guess == 0.16 and run.walk.done.choice == 1, "the answer by keys")

        def marked(there: float = at(160.0)) -> bool:
            # Drawn again for new words, so that either may be gone for a moment.
            chart, mark = page.locator("#duet-contact .chart").bounding_box(), page.locator(MARK).bounding_box()
            if chart is None or mark is None:
                return False
            beside = abs(mark["x"] + mark["width"] / 2.0 - there) < 2.0
            return beside and chart["y"] <= mark["y"] < chart["y"] + chart["height"]

        until(page, marked, "the mark at the guess")
        screenshot(page, f"guess-{width}")
    # It stays for the run, where it can no longer be moved.
    ask(session, lambda s: s.change("speed", 2.0))
    page.get_by_role("button", name="Run", exact=True).first.click()
    until(page, lambda: run.walk.done.outcome is not None, "the outcome")
    slider.wait_for(state="hidden")
    page.locator("#duet-contact text.guess").get_by_text("my guess 160").wait_for()
    screenshot(page, "guess-after")
