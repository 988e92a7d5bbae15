"""The projector in a real browser: window, stations, black and frozen screen, strip with a plot."""

from collections.abc import Callable, Iterator
from contextlib import closing

import pytest

from app.features.lecture.presenter import Station
from app.start import App
from tests.accessibility import accessible
from tests.app.conftest import ask
from tests.app.features.lecture.projected_class import (
    DARK,
    KEY,
    POSES,
    ProjectedClass,
    apart,
    bar_width,
    fits,
    strip,
)
from tests.browser import until
from tests.tabs import Tabs

pytestmark = pytest.mark.thorough


@pytest.fixture(scope="module")
def opened(lasting_lecture: Callable[[str], App], lasting_tabs: Tabs) -> Iterator[ProjectedClass]:
    with closing(ProjectedClass(lasting_lecture(KEY), lasting_tabs)) as projected:
        yield projected


@pytest.fixture
def hall(opened: ProjectedClass) -> ProjectedClass:
    """A class at its first question, with the scene on the projector."""
    opened.begin()
    return opened


def test_the_window_is_a_dark_screen_with_the_key_and_not_the_teachers_tab(hall: ProjectedClass) -> None:
    teacher, screen = hall.teacher, hall.screen
    screen.wait_for_function(DARK)
    # The window has the key, in neither address, and is not taken for the teacher's tab.
    assert "chalk" not in screen.url + teacher.url and "screen=1" in screen.url
    tabs = {page.evaluate("sessionStorage.getItem('duetResume')") for page in (teacher, screen)}
    assert len(tabs) == 2 and hall.tabs_before_the_student == ()
    teacher.get_by_text("screens: 1").wait_for()


def test_the_scene_fills_the_window(hall: ProjectedClass) -> None:
    screen = hall.screen
    canvas = "(() => { const box = __viserMutable.canvas.getBoundingClientRect(); return [box.width, box.height]; })()"
    # A new window may still change its size.
    until(
        screen,
        lambda: screen.evaluate(canvas) == screen.evaluate("[innerWidth, innerHeight]"),
        "the whole window",
    )
    assert not screen.get_by_text("Lesson", exact=True).is_visible()


def test_the_address_counts_students_until_a_page_key_hides_it(
    hall: ProjectedClass,
) -> None:
    teacher, address = hall.teacher, hall.screen.locator("#duet-overlay section")
    teacher.get_by_role("tab", name="Join", exact=True).click()
    teacher.get_by_text("1 are in").wait_for()
    teacher.get_by_label("students expected").fill("60")
    teacher.get_by_text("1 of 60 are in").wait_for()
    hall.host.control.post("invite")
    address.get_by_text("1 of 60 are in").wait_for()
    hall.screen.keyboard.press("PageDown")
    address.wait_for(state="detached")
    assert hall.station is Station.SCENE


def test_the_question_has_large_letters_that_fit_and_a_timer(hall: ProjectedClass) -> None:
    teacher, screen, over = hall.teacher, hall.screen, hall.over
    hall.show(Station.QUESTION)
    over.get_by_text("0 of 1 answered").wait_for()
    size = "parseFloat(getComputedStyle(document.querySelector('#duet-screen .question.duet p')).fontSize)"
    until(screen, lambda: abs(screen.evaluate(size) - 40.0) < 0.1 and fits(screen), "large letters that fit")
    teacher.get_by_role("button", name="60 s").click()
    over.get_by_role("timer").wait_for()
    teacher.get_by_text("time left: ").wait_for()


def test_at_the_reveal_the_bars_grow_where_they_are(hall: ProjectedClass) -> None:
    teacher, screen, over = hall.teacher, hall.screen, hall.over
    hall.show(Station.QUESTION)
    hall.answer()
    over.get_by_text("1 of 1 answered").wait_for()
    assert all(bar_width(screen, i) == 0.0 for i in range(4))
    screen.evaluate("window.kept = document.querySelector('#duet-screen li:nth-child(3) > div > div')")
    screen.keyboard.press("ArrowRight")
    over.locator(".at-answers").wait_for()
    until(screen, lambda: bar_width(screen, 2) > 300.0 and bar_width(screen, 0) == 0.0, "the answers")
    assert screen.evaluate("kept.isConnected")
    accessible(screen)
    until(teacher, lambda: teacher.get_by_role("button", name="Next: the run").count(), "what comes next")


def test_the_next_key_only_uncovers_a_black_screen(hall: ProjectedClass) -> None:
    teacher, screen, black = hall.teacher, hall.screen, hall.black
    hall.show(Station.ANSWERS)
    for key, covered in (("b", True), (".", False), ("b", True)):
        screen.keyboard.press(key)
        black.wait_for(state="visible" if covered else "hidden")
    teacher.get_by_text("the screen is black").wait_for()
    # The thumbnail on the teacher's page is black, too, and does not count as a screen.
    small = teacher.frame_locator(".duet-thumbnail iframe")
    small.locator("#duet-black").wait_for(state="visible")
    small.locator("#duet-screen .at-answers").wait_for(state="attached")
    assert teacher.get_by_text("screens: 1").count() == 1
    teacher.locator("body").click(position={"x": 500, "y": 30})
    teacher.keyboard.press("PageDown")
    black.wait_for(state="hidden")
    assert hall.station is Station.ANSWERS


def test_a_frozen_screen_hides_the_teachers_actions(hall: ProjectedClass) -> None:
    teacher, screen, over, session = hall.teacher, hall.screen, hall.over, hall.host.session
    hall.show(Station.ANSWERS)
    teacher.get_by_role("button", name="Frozen").click()
    teacher.get_by_text("the screen is frozen").wait_for()
    before, poses = over.inner_html(), screen.evaluate(POSES)
    begun = session.simulation.time
    teacher.get_by_role("button", name="Run", exact=True).click()
    until(teacher, lambda: session.simulation.time > begun + 0.5, "the run")
    assert hall.station is Station.RUN and over.inner_html() == before and screen.evaluate(POSES) == poses
    teacher.get_by_role("button", name="Live").click()
    over.locator(".at-run").wait_for()
    until(screen, lambda: screen.evaluate(POSES) != poses, "the run on the projector")


def test_one_plot_is_beside_the_runs_text_and_below_the_outcome(
    hall: ProjectedClass,
) -> None:
    screen, over = hall.screen, hall.over
    hall.show(Station.RUN)
    # During the run the step's first plot is a strip beside the text, without its panel.
    until(screen, lambda: strip(screen) == [1, 1] and apart(screen, ".caption"), "one plot beside the text")
    screen.keyboard.press("PageDown")
    over.locator(".at-outcome li.right").wait_for()
    until(
        screen,
        lambda: strip(screen) == [1, 1] and apart(screen, "main") and fits(screen),
        "one plot below the outcome",
    )
    screen.keyboard.press("PageUp")
    over.locator(".at-run").wait_for()


def test_the_outcome_marks_the_right_answer_and_names_the_moment(hall: ProjectedClass) -> None:
    screen = hall.screen
    hall.show(Station.OUTCOME)
    # Not only a colour marks the right answer.
    mark = "getComputedStyle(document.querySelector('#duet-screen li.right span'), '::after').content"
    until(screen, lambda: hall.over.locator("li.right").count(), "the right answer")
    assert screen.evaluate(mark) == '" ✓"'
    # The name of the shown moment is in the strip, not over the slide.
    root = "getComputedStyle(document.documentElement).getPropertyValue('--duet-moment-words')"
    until(screen, lambda: screen.evaluate(root), "the moment")
    assert screen.evaluate("getComputedStyle(document.body, '::after').content") == "none"


def test_letters_shrink_to_a_limit_and_then_the_strip_is_hidden(hall: ProjectedClass) -> None:
    screen, polls = hall.screen, hall.over.locator(".duet-poll")
    hall.show(Station.OUTCOME)
    until(screen, lambda: strip(screen) == [1, 1] and fits(screen), "the strip")
    sent = "document.querySelector('.duet-screen main')"
    screen.evaluate(f"{sent}.append({sent}.querySelector('.duet-poll').cloneNode(true))")
    until(screen, lambda: polls.count() == 2 and fits(screen) and strip(screen) == [0, 0], "no strip")
    screen.evaluate(f"{sent}.lastElementChild.remove()")
    until(screen, lambda: strip(screen) == [1, 1] and fits(screen), "the strip again")


def test_leaving_the_lessons_needs_a_confirmation(hall: ProjectedClass) -> None:
    teacher, lessons = hall.teacher, hall.host.lessons
    teacher.locator("body").click(position={"x": 500, "y": 30})
    teacher.keyboard.press("x")
    teacher.get_by_role("button", name="Stay").click()
    teacher.get_by_role("button", name="Stay").wait_for(state="detached")
    assert ask(hall.host.session, lambda _: lessons.open)
    teacher.get_by_role("button", name="Leave the lessons").click()
    teacher.get_by_role("button", name="Leave with the class").click()
    until(teacher, lambda: not lessons.open, "out of the lessons")
