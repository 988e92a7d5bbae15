"""What a student draws, in a real browser: a curve in the lesson's panel, by mouse, finger and keys, and a guess of d
on the line of contact, which chooses the answer, stays through the run, and survives a reload."""

import json

import pytest
from playwright.sync_api import Page

from app.features.lessons.bookmark import Phase
from app.features.lessons.outcomes import asks_for_distance, guessed_answer
from app.features.lessons.progress import Progress, from_json, to_json
from app.plots.curve_chart import COLUMNS
from app.session.session import Session
from controllers.curve import curve_through
from tests.app.conftest import OpenHouse, ask, live_sessions
from tests.app.features.lessons.helpers import our_book
from tests.app.page.by_hand import drag, drag_by_finger
from tests.browser import PageAt, close_software_note, screenshot, settled_box, until
from tests.tools.lesson_walker import enter

Point = tuple[float, float]


def on_the_board(page: Page, points: tuple[Point, ...]) -> list[Point]:
    """Where points of the axes are on the page; both coordinates from 0 to 1."""
    board = page.locator(".duet-draw")
    board.scroll_into_view_if_needed()
    left, top, wide, high = settled_box(page, board.locator(".paper"))
    return [(left + x * wide, top + (1.0 - height) * high) for x, height in points]


def by_mouse(page: Page, *points: Point) -> None:
    drag(page, on_the_board(page, points))


def near(curve: tuple[float | None, ...], expected: float, columns: slice) -> bool:
    return len(curve) == COLUMNS and all(v is not None and abs(v - expected) < 0.03 for v in curve[columns])


@pytest.mark.thorough
def test_by_mouse_finger_and_keys_the_truth_over_it_and_the_arm_that_obeys(
    house: OpenHouse, page_at: PageAt
) -> None:
    page = page_at(1000, 760, fresh=True)
    opened = house()
    session, run = enter(page, opened, "lesson=4&step=2")
    drawn = lambda: ask(session, lambda _: run.walk.done.drawing)  # noqa: E731
    board = page.get_by_role("application", name="Draw λ over distance d.")
    assert page.locator(".duet-chart").count() == 0, "the live curve would give it away"
    by_mouse(page, (0.0, 0.9), (1.0, 0.9))
    until(page, lambda: near(drawn(), 0.9, slice(0, COLUMNS)), "drawn by mouse")
    assert ask(session, lambda _: run.walk.phase) is Phase.PREDICT
    page.get_by_role("button", name="Clear").click()
    until(page, lambda: drawn() == (), "cleared")
    board.focus()
    page.keyboard.press("Home")
    page.keyboard.press("PageUp")
    for _ in range(4):
        page.keyboard.press("ArrowRight")
    for _ in range(3):
        page.keyboard.press("ArrowDown")
    page.get_by_text("d = 73.4 mm, λ = 0.54").wait_for()
    until(page, lambda: near(drawn(), 0.6, slice(0, 1)) and near(drawn(), 0.54, slice(4, 5)), "drawn by keys")
    assert near(drawn(), 0.57, slice(2, 3)) and drawn()[5] is None, "straight over the gap"
    assert ask(session, lambda _: run.walk.phase) is Phase.PREDICT, (
        "the arrows are the board's here, not the lesson's"
    )
    by_mouse(page, (1.0, 0.8), (0.0, 0.8))
    until(page, lambda: near(drawn(), 0.8, slice(0, COLUMNS)), "drawn backwards")
    drag_by_finger(page, on_the_board(page, ((0.51, 0.1), (0.7, 0.1), (1.0, 0.1))))
    until(page, lambda: near(drawn(), 0.1, slice(25, COLUMNS)), "drawn over by a finger")
    assert near(drawn(), 0.8, slice(0, 23))
    screenshot(page, "drawing")

    page.reload()
    page.locator(".duet-draw .pencil").wait_for(state="attached")
    close_software_note(page)
    until(
        page,
        lambda: page.locator(".pencil").evaluate("path => path.getTotalLength()") > 40,
        "what was drawn before",
    )
    # Slow, so that the run is not over before it is skipped.
    until(page, lambda: len(live_sessions(opened)) == 1, "the session of the page that came again")
    (session,) = live_sessions(opened).values()
    ask(session, lambda s: s.change("speed", 0.25))
    page.get_by_role("button", name="Run", exact=True).click()
    page.locator(".duet-l-said figure").wait_for()
    page.locator(".duet-draw").wait_for(state="detached")
    page.get_by_role("button", name="Skip the run").click()
    verdict = page.locator(".duet-l-verdict")
    verdict.get_by_text("Your curve is off by 0.", exact=False).wait_for()
    assert verdict.get_by_text("by the formula").count() == 1 and verdict.locator("path.lam").count() >= 1
    said = page.locator("#duet-say")
    until(page, lambda: "Your curve is off by" in (said.text_content() or ""), "read out")
    assert "250" not in (said.text_content() or "").split(), "the numbers of the axes are not read out"
    page.locator(".duet-chart").wait_for()
    screenshot(page, "drawing-verdict")

    # The drawn curve as the law of the arm.
    law = lambda: ask(session, lambda one: one.settings.run.law.law)  # noqa: E731
    page.get_by_role("button", name="Run with my curve").click()
    until(page, lambda: law() == "drawn_curve", "the arm obeys it")
    page.get_by_text("Your curve at work: ").first.wait_for()
    page.get_by_role("button", name="Back to the outcome").click()
    until(page, lambda: law() == "smooth_priority", "back")

    page.get_by_role("button", name="Leave the lessons").click()
    page.get_by_role("tab", name="Law").wait_for()
    see_the_arm_obey(page, session)


def see_the_arm_obey(page: Page, session: Session) -> None:
    """Outside of the lessons the arm obeys a curve that is drawn or typed."""
    page.set_viewport_size({"width": 1440, "height": 900})
    ask(session, lambda s: [s.change("scene", "ball"), s.change("law", "drawn_curve")])
    curve = lambda: ask(session, lambda one: one.settings.run.law.curve)  # noqa: E731
    board = page.get_by_role("application", name="Draw λ over distance d.")
    board.scroll_into_view_if_needed()
    until(
        page,
        lambda: page.locator(".pencil").evaluate("path => path.getTotalLength()") > 40,
        "the curve of the settings",
    )
    by_mouse(page, (0.0, 1.0), (0.5, 1.0), (1.0, 0.0))
    until(page, lambda: curve() != "0.15:1,0.2:0.3,0.4:0", "drawn by mouse")
    drawn = curve_through(curve())
    assert (
        drawn.height(0.1) > 0.95
        and abs(drawn.height(0.3) - 0.5) < 0.08
        and drawn.height(0.4) < 0.08
        and len(drawn.heights) < 12
    )
    assert ask(session, lambda one: one.simulation.law.activation(0.3)) == drawn.height(0.3)
    screenshot(page, "drawn-curve")

    box = page.get_by_role("textbox", name="λ(d)")
    box.fill("0.1:1,0.2")
    page.get_by_role("alert").get_by_text("cannot be read").wait_for()
    box.fill("0.1:1,0.20:0")
    until(page, lambda: curve() == "0.1:1,0.2:0", "typed")
    page.get_by_role("alert").wait_for(state="hidden")
    assert box.input_value() == "0.1:1,0.20:0", "what is typed is left as it is"
    heights = lambda: json.loads(page.locator(".duet-draw").get_attribute("data-curve") or "[]")  # noqa: E731
    until(page, lambda: heights()[:2] == [1, 1] and heights()[-1] == 0, "the board follows")


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


def test_a_guess_is_kept_and_a_wild_one_is_not() -> None:
    progress = Progress()
    progress.at("smooth", "rest").guess = 0.16
    assert from_json(to_json(progress)).at("smooth", "rest").guess == 0.16
    assert from_json(to_json(progress).replace("0.16", '"0.16"')).at("smooth", "rest").guess is None


@pytest.mark.thorough
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
        until(
            page,
            lambda: run.walk.done.choice == 2 and abs((run.walk.done.guess or 0.0) - 0.22) < 0.006,
            "the nearest answer",
        )
        guess = run.walk.done.guess
        assert guess is not None
        # By keys, to another answer.
        slider.focus()
        for _ in range(round(1000.0 * guess) - 160):
            page.keyboard.press("ArrowLeft")
        until(page, lambda: run.walk.done.guess == 0.16 and run.walk.done.choice == 1, "the answer by keys")

        def marked(there: float = at(160.0)) -> bool:
            # Drawn again for new words, so that either may be gone for a moment.
            chart, mark = (
                page.locator("#duet-contact .chart").bounding_box(),
                page.locator(MARK).bounding_box(),
            )
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
