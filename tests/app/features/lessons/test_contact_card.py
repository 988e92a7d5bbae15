"""The contact card in a lesson; see also `tests/app/page/test_contact_card.py`."""

from dataclasses import dataclass

import pytest
from playwright.sync_api import Page

from app.features.lessons.bookmark import Phase
from app.features.lessons.session.lesson_actions import Choose, Press
from app.features.lessons.session.lesson_session import LessonSession
from app.session.session import Session
from tests.app.conftest import OpenHouse, ask
from tests.app.features.lessons.helpers import unfold_controls
from tests.browser import PageAt, screenshot, until
from tests.tools.lesson_walker import enter, shown_step

pytestmark = pytest.mark.thorough

LAW = (
    "#duet-contact .curve",
    "#duet-contact text.lam",
    "#duet-contact text.rest",
    "#duet-contact .term",
    "#duet-contact .trend",
)


@dataclass(frozen=True)
class Student:
    page: Page
    session: Session
    run: LessonSession

    def go_to(self, lesson: int, step: int) -> None:
        """Go to the beginning of a step (0-based lesson and step)."""
        shown_step(self.page, self.session, self.run, lesson, step)
        ask(self.session, lambda _: self.run.act(Press("reset")))
        until(self.page, lambda: self.run.walk.phase is self.run.walk.phases[0], "the beginning of the step")

    def seen(self) -> set[str]:
        """Visible parts of the card about the law."""
        return {
            part
            for part in LAW
            if any(text.strip() for text in self.page.locator(f"{part}:visible").all_text_contents())
        }


@pytest.fixture(scope="module")
def student(lasting_house: OpenHouse, lasting_page_at: PageAt) -> Student:
    opened, page = lasting_house(), lasting_page_at(1280, 800)
    return Student(page, *enter(page, opened, "lesson=3&step=1&lang=en"))


@pytest.mark.parametrize(
    ("lesson", "step"),
    [(2, 0), (3, 1), (5, 0), (1, 2)],
    ids=["an endless retreat", "a curve to draw", "the resting distance", "what becomes of an error"],
)
def test_the_card_hides_the_answer_to_a_steps_question(student: Student, lesson: int, step: int) -> None:
    page, pill = student.page, student.page.locator(".duet-status").filter(has_text="is promised")
    student.go_to(lesson, step)
    page.locator("#duet-contact.asks").wait_for()
    until(page, lambda: page.locator("#duet-contact .gap b").inner_text() != "", "d, or |e|")
    until(page, lambda: pill.count() == 0, "no word of the promise")
    assert student.seen() == set() and not page.locator("#duet-contact .curve").is_visible()
    assert page.locator("#duet-contact .note").inner_text() == ""
    label = page.locator("#duet-contact-picture").get_attribute("aria-label") or ""
    assert "λ" not in label and "priority" not in label and "grows" not in label
    assert page.evaluate("duet.symbols?.lam") is None and page.get_by_text("unstable").count() == 0
    screenshot(page, f"asks-{lesson + 1}.{step + 1}")


def test_d_is_highlighted_in_a_line_of_text_and_in_the_card(student: Student) -> None:
    page = student.page
    student.go_to(3, 1)
    inline = page.locator(".duet-lesson p path.d")
    inline.first.wait_for()

    def lit_in_the_text() -> bool:
        inline.first.hover(force=True)
        return inline.first.evaluate("(d) => d.classList.contains('duet-lit')")

    until(page, lit_in_the_text, "d in a line of text")
    until(page, lambda: page.locator("#duet-contact .d.duet-lit").count() > 0, "d in the card")
    page.mouse.move(640, 300)


def test_the_law_is_shown_after_the_prediction_during_the_run(student: Student) -> None:
    page, pill = student.page, student.page.locator(".duet-status").filter(has_text="is promised")
    student.go_to(3, 1)
    ask(student.session, lambda _: [student.run.act(Choose(0)), student.run.act(Press("run"))])
    until(page, lambda: {LAW[1], LAW[3], LAW[4]} <= student.seen(), "the law")
    page.locator("#duet-contact .curve").wait_for()
    unfold_controls(page)
    pill.first.wait_for()


def test_d_is_highlighted_in_the_equation_of_the_explanation(student: Student) -> None:
    page, run = student.page, student.run
    student.go_to(3, 1)
    ask(student.session, lambda _: [run.act(Choose(0)), run.act(Press("run"))])
    ask(student.session, lambda _: setattr(run.walk, "phase", Phase.EXPLAIN))
    hits = page.locator(".duet-l-explain .hit[data-symbol=d]")
    hits.first.wait_for()
    page.mouse.move(640, 300)

    def lit_in_the_equation() -> bool:
        # A redraw with the run's numbers loses the focus.
        hits.nth(1).focus()
        return page.locator(".duet-l-explain path.d.duet-lit").count() == 4

    until(page, lit_in_the_equation, "d in eq. (31)")
