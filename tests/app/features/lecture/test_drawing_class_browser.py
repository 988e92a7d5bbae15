"""A class draws curves in real browsers: all for the teacher, the median and the true curve for all."""

import re
from collections.abc import Callable

import numpy as np
import pytest
from playwright.sync_api import Locator, Page

from app.features.classroom.ballots import Ballots
from app.features.lecture.lecture import LectureHost
from app.features.lessons.bookmark import Phase
from app.features.lessons.session.lesson_actions import GoTo, Press
from app.plots.curve_chart import COLUMNS
from app.session.session import Session
from app.start import App
from tests.app.conftest import ask
from tests.app.features.lecture.lecture_room import lecture_of
from tests.app.features.lecture.test_browser import WAIT, come
from tests.app.features.lessons.test_drawing_browser import by_mouse
from tests.browser import screenshot, until
from tests.tabs import Tabs

pytestmark = pytest.mark.thorough

KEY = "chalk"


class DrawingClass:
    """A teacher and two students in browsers, at the question of lesson 4 that asks for a curve."""

    def __init__(self, opened: App, tabs: Tabs) -> None:
        self.host: LectureHost = lecture_of(opened)
        self.teacher, self.ann, self.bo = (
            tabs.open(1000, 700),
            tabs.open(640, 600),
            tabs.open(640, 600),
        )
        come(self.teacher, f"{opened.url}/?key={KEY}&lesson=4&step=2")
        for page in self.students:
            come(page, opened.url)

    @property
    def students(self) -> tuple[Page, Page]:
        return self.ann, self.bo

    @property
    def cloud(self) -> Locator:
        """The class's curves and answers on the teacher's page."""
        return self.teacher.locator(".duet-poll")

    def begin(self) -> None:
        """Return to empty boards."""
        host = self.host

        def start_again(_: Session) -> None:
            host.classroom.ballots = Ballots()
            for action in (GoTo(4, 1), Press("reset")):
                host.lessons.act(action)

        self.teacher.set_viewport_size({"width": 1000, "height": 700})
        ask(host.session, start_again)
        for page in self.students:
            page.locator(".duet-draw").wait_for()
        until(
            self.teacher, lambda: self.cloud.get_by_text("0 answered").count(), "a poll without answers", WAIT
        )

    def draw(self) -> None:
        """Give each student a falling curve, without a mouse."""
        host = self.host

        def take(_: Session) -> list[bool]:
            walk = host.lessons.walk
            question = walk.lesson.id, walk.step.id
            curves = (tuple(np.linspace(high, high - 0.6, COLUMNS)) for high in (0.9, 0.7))
            here = host.classroom.here
            return [host.classroom.draw(walk, one, question, c) for one, c in zip(here, curves, strict=True)]

        assert ask(host.session, take) == [True, True]
        self.cloud.get_by_text("2 drawn").wait_for()

    def go_on(self, *phases: Phase) -> None:
        for phase in phases:
            ask(self.host.session, lambda _: self.host.lessons.act(Press("next")))
            until(
                self.teacher,
                lambda phase=phase: ask(self.host.session, lambda _: self.host.lessons.walk.phase) is phase,
                phase.value,
                WAIT,
            )


@pytest.fixture(scope="module")
def opened(lasting_lecture: Callable[[str], App], lasting_tabs: Tabs) -> DrawingClass:
    return DrawingClass(lasting_lecture(KEY), lasting_tabs)


@pytest.fixture
def drawing_class(opened: DrawingClass) -> DrawingClass:
    opened.begin()
    return opened


def test_the_board_is_above_the_answers_and_keeps_its_curve(drawing_class: DrawingClass) -> None:
    by_mouse(drawing_class.ann, (0.0, 0.9), (1.0, 0.3))
    by_mouse(drawing_class.bo, (0.0, 0.7), (1.0, 0.1))
    for page in drawing_class.students:
        # The box for a reason appears, and the board keeps its curve.
        page.get_by_label("Because …").wait_for()
        assert page.locator(".duet-draw .pencil").get_attribute("d")
        board, answer = (
            found.bounding_box()
            for found in (page.locator(".duet-draw"), page.get_by_role("button", name=re.compile("^1 ")))
        )
        assert board and answer and board["y"] < answer["y"], "the board is above the answers"
    drawing_class.cloud.get_by_text("2 answered (0 chose, 2 drew)").wait_for()


def test_before_the_reveal_only_the_teacher_sees_the_curves(drawing_class: DrawingClass) -> None:
    cloud = drawing_class.cloud
    drawing_class.draw()
    cloud.get_by_text("2 answered (0 chose, 2 drew) · 0 not yet").wait_for()
    assert cloud.locator("path[stroke-opacity='0.3']").count() == 2
    assert drawing_class.ann.locator(".duet-poll").count() == 0


def test_the_reveal_shows_the_median_and_the_outcome_the_true_curve(drawing_class: DrawingClass) -> None:
    teacher, ann, host = drawing_class.teacher, drawing_class.ann, drawing_class.host
    drawing_class.draw()
    teacher.get_by_role("button", name="Reveal to everybody").click()
    for page in drawing_class.students:
        page.locator(".duet-poll").get_by_text("median").wait_for()
        page.locator(".duet-draw").wait_for(state="detached")
    drawing_class.go_on(Phase.DO, Phase.OBSERVE)
    prediction = ask(host.session, lambda _: host.lessons.walk.done.drawing[0])
    assert prediction is not None, "the class's median is the prediction of the shared session"
    for page in (teacher, ann):
        page.locator(".duet-poll").get_by_text("by the formula").first.wait_for()
        screenshot(page, f"drawing-class-{'teacher' if page is teacher else 'student'}")
    ann.locator(".duet-lesson:not(.duet-l-verdict) > .card").get_by_text("Your curve is off by 0.").wait_for()


def test_a_narrow_window_shows_one_plot_between_the_panels(drawing_class: DrawingClass) -> None:
    teacher = drawing_class.teacher
    drawing_class.draw()
    teacher.get_by_role("button", name="Reveal to everybody").click()
    drawing_class.ann.locator(".duet-draw").wait_for(state="detached")
    drawing_class.go_on(Phase.DO, Phase.OBSERVE)
    captions = teacher.locator("[data-duet-holds~=plots] [data-duet-holds~=caption]:visible")
    for width, shown in ((1000, ["distance", "Fig. 2: "]), (900, ["Fig. 2: "])):
        teacher.set_viewport_size({"width": width, "height": 700})
        until(
            teacher,
            lambda shown=shown: [text[:8] for text in captions.all_inner_texts()] == shown,
            f"{shown}",
            WAIT,
        )
    # Each curve's name fits on one line.
    names = "[...document.querySelectorAll('.duet-chart .name.faint')].map(name => name.offsetHeight)"
    high = teacher.evaluate(names)
    assert len(high) == 3 and max(high) < 16
    screenshot(teacher, "drawing-class-slim")
