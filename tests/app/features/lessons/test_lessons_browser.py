"""Lessons in a real browser: steps of each kind by clicks or keys, pictures, the list, no WebGL;
`python -m tests.tools.walk_lessons` walks all of them."""

import re
from dataclasses import dataclass

import numpy as np
import pytest
from playwright.sync_api import Browser, Page

from app.features.lessons.bookmark import Phase
from app.features.lessons.session.lesson_actions import Choose, Press
from app.features.lessons.session.lesson_session import LessonSession
from app.session.session import Session
from app.settings import Settings
from scenes.settings import changed, values
from tests.accessibility import accessible
from tests.app.conftest import OpenHouse, ask
from tests.app.page.by_hand import hand, see_plots
from tests.browser import FLAGS, PageAt, installed_browser, screenshot, until
from tests.fonts import font_environment
from tests.tools.lesson_hands import Clicks, Keys, press
from tests.tools.lesson_moves import LONG
from tests.tools.lesson_walker import Walker, enter, named, shown_step


def at_the_end(run: LessonSession) -> bool:
    return run.walk.phase is run.walk.phases[-1]


def test_a_question_and_its_challenge_by_clicks(house: OpenHouse, page_at: PageAt) -> None:
    opened = house(changed(Settings(), "dm", 0.12))
    page = page_at(1440, 900)
    session, run = enter(page, opened, "lesson=4&step=4")
    walker = Walker(page, session, run, Clicks(page))
    walker.check = accessible
    walked = walker.step()
    assert at_the_end(run) and len(walked.said) == 3 and walked.whys == 2 and walked.challenge == "passed"
    assert walked.said[0] != walked.said[2], "a wrong and a right answer have different replies"
    box = page.locator(".duet-l-head").bounding_box()
    canvas = page.evaluate(
        "(() => { const b = __viserMutable.canvas.getBoundingClientRect(); return [b.left, b.right]; })()"
    )
    assert box is not None and box["x"] + box["width"] <= canvas[0] + 1.0, (
        "the panel is beside the scene, not over it"
    )
    screenshot(page, "lesson-challenge")
    assert page.get_by_role("button", name="Leave the lessons").count() == 1
    assert not page.get_by_role("button", name="Lessons", exact=True).is_visible()
    press(page, "Leave the lessons")
    until(page, lambda: not run.open, "leaving")
    page.get_by_role("button", name="Lessons", exact=True).wait_for()
    mine, expected = values(session.settings), values(changed(Settings(), "dm", 0.12))
    assert {key for key in mine if mine[key] != expected[key]} <= {"picture", "lang"}


PICTURE = """(() => {
  const picture = document.querySelector('.duet-l-text svg.picture'), box = picture.getBoundingClientRect();
  const panel = picture.closest('.duet-lesson').parentElement.getBoundingClientRect();
  const inside = [...picture.querySelectorAll('path, text, circle')].map(shape => shape.getBoundingClientRect())
    .every(b => b.left > box.left - 2 && b.right < box.right + 2 && b.top > box.top - 2 && b.bottom < box.bottom + 2);
  const colour = where => getComputedStyle(picture.querySelector(where)).color;
  return [box.width / panel.width, box.width / box.height, inside, colour('path'), colour('.d > *')];
})()"""
"""A step's picture: share of the panel's width, aspect ratio, all shapes inside, two colours."""


def see_picture(page: Page, session: Session, run: LessonSession, word: str) -> None:
    """Check the picture of the present step's explanation, which contains `word`, in both themes."""
    question = run.walk.step.question
    assert question is not None
    ask(session, lambda _: run.act(Choose(question.right)))
    while run.walk.phase is not Phase.EXPLAIN:
        ask(session, lambda _: run.act(Press("next")))
        until(page, lambda: run.walk.phase in (Phase.OBSERVE, Phase.EXPLAIN), "the outcome", LONG)
    picture = page.locator(".duet-l-text svg.picture")
    picture.get_by_text(word, exact=True).wait_for()
    assert "![" not in page.locator("body").inner_text()
    colours: dict[str, list[str]] = {}
    for theme in ("light", "dark"):
        ask(session, lambda s, theme=theme: s.change("theme", theme))
        page.locator(f"[data-mantine-color-scheme={theme}]").first.wait_for()
        picture.scroll_into_view_if_needed()

        def as_it_should_be(theme: str = theme) -> bool:
            share, form, inside, *colours[theme] = page.evaluate(PICTURE)
            # Ink and symbol have different colours, and both follow the theme.
            differ = len({colour for seen in colours.values() for colour in seen}) == 2 * len(colours)
            return 0.85 < share <= 1.0 and 1.5 < form < 2.3 and inside and differ

        until(page, as_it_should_be, f"the picture, {theme}")
        screenshot(page, f"lesson-picture-{run.walk.lesson.number}-{theme}")


@pytest.mark.thorough
def test_pictures_have_the_colours_of_the_page(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(1440, 900)
    session, run = enter(page, house(), "lesson=1&step=2&lang=de&theme=light")
    see_picture(page, session, run, "Ellbogen")
    shown_step(page, session, run, 9, 2)
    see_picture(page, session, run, "glatt")


@dataclass(frozen=True)
class Student:
    page: Page
    session: Session
    run: LessonSession

    def is_at(self, lesson: int, step: int) -> bool:
        return (self.run.walk.lesson.number, self.run.walk.step_index) == (lesson, step)


@pytest.fixture(scope="module")
def student(lasting_house: OpenHouse, lasting_page_at: PageAt) -> Student:
    opened, page = lasting_house(), lasting_page_at(1024, 768)
    return Student(page, *enter(page, opened, "lesson=1&step=2&theme=dark"))


@pytest.mark.thorough
def test_the_list_continues_at_the_first_unfinished_step(student: Student) -> None:
    """Must be the first test with this page: the student has no progress yet."""
    page, session, run = student.page, student.session, student.run
    question = run.walk.step.question
    assert question is not None
    page.get_by_text(run.walk.lesson.goal).wait_for(state="detached")
    ask(session, lambda _: run.act(Choose(question.right)))
    until(page, lambda: run.walk.phase is Phase.DO, "the answer")
    ask(session, lambda _: run.act(Press("next")))
    until(page, lambda: run.walk.phase is Phase.OBSERVE, "the outcome", LONG)
    press(page, "All lessons")
    cards = page.locator("button.lesson")
    cards.nth(12).wait_for()
    page.locator(".duet-l-head").wait_for(state="detached")
    assert cards.count() == len(run.book.lessons)
    assert [cards.nth(i).locator(".ticks .ok").count() for i in range(4)] == [0, 1, 0, 0]
    assert ["continue" in cards.nth(i).inner_text() for i in (1, 2)] == [True, False]
    assert run.book.lessons[2].promise in cards.nth(2).inner_text()
    assert "15\N{NO-BREAK SPACE}min" in cards.nth(2).inner_text()
    named(page)
    screenshot(page, "lesson-list")
    cards.nth(2).focus()
    page.keyboard.press("Enter")
    page.locator(".duet-l-head").get_by_text("A computer moves in steps.").wait_for()
    until(page, lambda: cards.count() == 0, "no list")
    assert student.is_at(2, 0)
    press(page, "All lessons")
    cards.nth(1).click()
    until(page, lambda: student.is_at(1, 0), "the first step that is not finished")


@pytest.mark.thorough
def test_the_test_before_lesson_1_has_no_run_and_shows_no_right_answer(student: Student) -> None:
    page, run = student.page, student.run
    shown_step(page, student.session, run, 0, 1)
    press(page, "All lessons")
    page.locator("button.lesson").first.click()
    page.locator(".duet-l-head").get_by_text("Thirteen questions").wait_for()
    run_button = page.get_by_role("button", name=re.compile("^Run"))
    until(page, lambda: run_button.count() == 0, "no button to run")
    page.keyboard.press("3")
    until(page, lambda: run.walk.done.choice == 2, "the answer")
    press(page, "Next step")
    until(page, lambda: run.walk.step_index == 1, "the next question")
    assert page.locator(".duet-lesson .card").count() == 0
    assert run.walk.done_in("beliefs", "null_space").outcome is None
    screenshot(page, "test-before")


STEP_BUTTONS = """() => {
  const buttons = [...document.querySelectorAll('[data-duet-holds~=lesson] button')];
  const boxes = buttons.filter((one) => /^(● )?[0-9]$/.test(one.textContent)).map((one) => one.getBoundingClientRect());
  return boxes.map(({ left, top, width }) => [left, top, width]);
}"""
"""Left, top and width of the buttons of a lesson's steps [CSS px]."""


@pytest.mark.thorough
def test_six_steps_are_one_row_that_no_mark_moves(student: Student) -> None:
    page, places = student.page, []
    for step in (0, 4):
        shown_step(page, student.session, student.run, 9, step)
        page.get_by_role("button", name=f"● {step + 1}", exact=True).wait_for()
        places.append(page.evaluate(STEP_BUTTONS))
    first, fifth = np.array(places)
    assert len(first) == 6 and len(set(first[:, 1])) == len(set(fifth[:, 1])) == 1, places
    np.testing.assert_allclose(first[:, [0, 2]], fifth[:, [0, 2]], atol=1.0)


@pytest.mark.thorough
def test_keys_alone_swing_an_elbow_and_enter_numbers(student: Student) -> None:
    page, session, run = student.page, student.session, student.run
    shown_step(page, session, run, 0, 2)
    walker = Walker(page, session, run, Keys(page))
    assert walker.step().challenge == "passed"
    page.keyboard.press("n")
    until(page, lambda: run.walk.lesson is run.book.lessons[2], "the next lesson")
    page.keyboard.press("ArrowLeft")
    until(page, lambda: run.walk.lesson is run.book.lessons[1] and at_the_end(run), "back")
    shown_step(page, session, run, 2, 2)
    assert walker.step().challenge == "passed"
    named(page)
    page.keyboard.press("x")
    until(page, lambda: not run.open, "leaving")


WITHOUT_WEBGL = ("--disable-gpu", "--disable-software-rasterizer", "--disable-3d-apis")


@pytest.mark.thorough
def test_lessons_plots_numbers_and_keys_work_without_webgl(house: OpenHouse, browser: Browser) -> None:
    flags = [flag for flag in FLAGS if "gl" not in flag] + list(WITHOUT_WEBGL)
    with browser.browser_type.launch(
        executable_path=installed_browser(), args=flags, env={**font_environment("wide")}
    ) as without:
        page = without.new_page(locale="de-AT", viewport={"width": 1200, "height": 720})
        errors: list[str] = []
        page.on("pageerror", lambda error: errors.append(str(error)))
        session, run = enter(page, house(), "lang=en&lesson=1&step=1")
        assert page.evaluate("document.createElement('canvas').getContext('webgl')") is None
        note = page.get_by_role("note")
        note.get_by_text("WebGL is switched off").wait_for()
        question, keys = run.walk.step.question, Keys(page)
        assert question is not None
        keys.choose(question.right)
        ask(session, lambda s: s.change("speed", 2.0))
        page.get_by_role("button", name="Run", exact=True).wait_for()
        keys.do("run")
        page.locator(".duet-l-verdict .card .mark b").get_by_text("You predicted it.", exact=True).wait_for()
        see_plots(page, ("hand error |e| [mm]", "elbow angle"))
        page.keyboard.press("x")
        until(page, lambda: not run.open, "leaving")
        # A hand that goes down by itself would hide the key's effect.
        ask(session, lambda s: s.change("autopilot", False))
        place = hand(session)
        page.keyboard.press("ArrowUp")
        until(page, lambda: hand(session)[2] > place[2] + 0.01, "a hand that goes up")
        page.locator("#duet-contact .gap b", has_text=re.compile(r"^\d+(\.\d)?$")).wait_for()
        ask(session, lambda s: s.change("lang", "auto"))
        note.get_by_text("WebGL ist in diesem Browser ausgeschaltet").wait_for()
        plots = page.locator("[data-floating-window]:has(.duet-plots)")

        def above_the_plots() -> bool:
            upper, lower = note.bounding_box(), plots.bounding_box()
            return upper is not None and lower is not None and upper["y"] + upper["height"] <= lower["y"]

        until(page, above_the_plots, "the note above the plots")
        assert errors == []
