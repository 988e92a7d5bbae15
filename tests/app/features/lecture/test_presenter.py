"""The projector without a page: stations follow the lesson, the clicker goes through them, and what lies over the scene."""

import itertools
import re
from dataclasses import replace
from functools import partial
from time import monotonic
from unittest.mock import MagicMock, Mock

import pytest

from app.features.classroom.ballots import Tally
from app.features.classroom.classroom import Classroom, Poll
from app.features.classroom.classroom_html import poll_html, tied_html
from app.features.classroom.student_work import BoardRow
from app.features.lecture import teacher_panel
from app.features.lecture.overlays import screen_html
from app.features.lecture.presenter import Presenter, Station, stations_of
from app.features.lecture.screen_panel import next_station_label
from app.features.lecture.teacher_control import Because, TeacherControl
from app.features.lessons.bookmark import Phase
from app.features.lessons.session.lesson_actions import Choose, GoTo, Press
from app.plots.curve_chart import COLUMNS
from app.session.frame import make_frame
from app.session.session import Session
from app.settings import LANGUAGES, Settings
from tests.app.features.lessons.helpers import lessons_in, our_book

BOOK = our_book()

FRAME = 0.0625
"""Time of a frame, without an error of rounding [s]."""


class Stage:
    """A lecture's stage without a server: frames are made by hand."""

    def __init__(self) -> None:
        self.session, self._now = Session(Settings()), 100.0
        self.lessons, self.classroom = lessons_in(self.session, BOOK), Classroom(8)
        self.control = TeacherControl(self.classroom, self.session, self.lessons)
        self.presenter = self.control.presenter = Presenter(lambda: self._now)
        self.lessons.enter(0, 0)
        self.frame()

    def frame(self, count: int = 1) -> Station:
        for _ in range(count):
            self._now += FRAME
            make_frame(self.session, self._now, FRAME)
            self.control.present()
        return self.presenter.station

    def act(self, *actions: str) -> Station:
        for action in actions:
            self.control.post(action)  # type: ignore[arg-type]
            self.frame()
        return self.presenter.station

    def answer(self, *choices: int) -> None:
        for i, choice in enumerate(choices):
            self.classroom.enter(i, f"student {i}")
            assert self.classroom.answer(self.lessons.walk, f"student {i}", choice)

    def until(self, station: Station) -> None:
        """Frames until the run is over, and what it is measured by is computed beside it, in a thread."""
        deadline = monotonic() + 60.0
        while self.frame() is not station:
            assert monotonic() < deadline, (station, self.presenter.station)


@pytest.fixture
def stage(fast_machine: None) -> Stage:
    del fast_machine
    return Stage()


def test_a_clicker_goes_through_a_step_and_back(stage: Stage) -> None:
    walk = stage.lessons.walk
    assert stage.presenter.station is Station.SCENE and stations_of(walk)[:4] == tuple(Station)[:4]
    assert stage.act("on") is Station.QUESTION and stage.session.paused
    # Without an answer there is nothing to reveal, and the lesson says what it waits for.
    stage.session.notices.clear()
    assert stage.act("on") is Station.QUESTION and stage.session.notices[0][0] == "Predict first"
    stage.answer(0, 2, 2)
    assert stage.act("on") is Station.ANSWERS
    poll = stage.control.poll()
    assert poll is not None and poll.revealed and stage.session.paused and walk.phase is Phase.DO
    assert stage.act("on") is Station.RUN and not stage.session.paused
    stage.frame(20)
    # Back to the answers, which stay revealed, while the run waits; and on with it.
    assert (
        stage.act("back") is Station.ANSWERS and stage.session.paused and stage.session.simulation.steps > 0
    )
    # From the answers to the question, which does not show them.
    assert stage.act("back") is Station.QUESTION
    poll = stage.control.poll()
    assert poll is not None and poll.revealed
    assert "width:67%" in screen(stage, poll, Station.ANSWERS) and "width:67%" not in screen(
        stage, poll, Station.QUESTION
    )
    assert stage.act("on") is Station.ANSWERS and stage.act("back") is Station.QUESTION
    assert stage.act("back") is Station.SCENE
    assert [stage.act("on") for _ in range(3)] == [
        Station.QUESTION,
        Station.ANSWERS,
        Station.RUN,
    ] and not stage.session.paused
    # Once more ends the run, and its outcome follows by itself.
    stage.act("on")
    stage.until(Station.OUTCOME)
    poll = stage.control.poll()
    assert poll is not None and poll.outcome
    stations = [stage.act("on") for _ in range(4)]
    assert stations == [Station.EXPLANATION, Station.CHALLENGE, Station.TRY, Station.SCENE]
    assert walk.step_index == 1
    assert stage.act("back") is Station.CHALLENGE and walk.step_index == 0
    assert [stage.act("back") for _ in range(3)] == [Station.EXPLANATION, Station.OUTCOME, Station.RUN]


def test_the_projector_follows_what_the_teacher_does_otherwise(stage: Stage) -> None:
    stage.answer(1, 1)
    stage.act("on")
    assert stage.act("reveal") is Station.ANSWERS
    # Asked again, the question is there again.
    assert stage.act("again") is Station.QUESTION
    # An answer for the class, by the teacher's own button, and Run.
    stage.lessons.act(Choose(1))
    assert stage.frame() is Station.RUN and stage.session.paused
    assert stage.act("back") is Station.QUESTION
    stage.lessons.act(Press("run"))
    assert stage.frame() is Station.RUN and not stage.session.paused
    stage.lessons.act(GoTo(3, 1))
    assert stage.frame() is Station.SCENE
    stage.lessons.leave()
    assert stage.frame() is Station.SCENE and stage.act("on") is Station.SCENE


def test_every_step_of_every_lesson_has_a_next_station_up_to_the_next_step(stage: Stage) -> None:
    walk = stage.lessons.walk
    for i, lesson in enumerate(BOOK.lessons):
        for k in range(len(lesson.steps)):
            walk.go(i, k)
            stations = stations_of(walk)
            assert len(set(stations)) == len(stations)
            for station, after in itertools.pairwise((*stations, None)):
                assert station is not None
                stage.presenter.show(station)
                assert stage.presenter.following(walk) is after


def test_a_page_key_first_brings_back_a_covered_picture(stage: Stage) -> None:
    presenter = stage.presenter
    walk = stage.lessons.walk
    says = next_station_label(presenter, presenter.following(walk))
    assert says == "Next: the question"
    for cover in ("blank", "freeze", "invite", "invite all"):
        stage.act(cover)
        assert presenter.blank or presenter.frozen or presenter.inviting
        assert next_station_label(presenter, presenter.following(walk)) == "Next: the picture again"
        assert stage.act("on") is Station.SCENE and not (
            presenter.blank or presenter.frozen or presenter.inviting
        )
        assert next_station_label(presenter, presenter.following(walk)) == says
    assert stage.act("on") is Station.QUESTION
    stage.act("blank", "freeze", "live")
    assert not (presenter.blank or presenter.frozen)


def test_two_presses_between_two_frames_are_two(stage: Stage) -> None:
    stage.answer(1, 1)
    for action, value in (
        ("on", ""),
        ("on", ""),
        ("blank", ""),
        ("blank", ""),
        ("expect", "20"),
        ("expect", "30"),
    ):
        stage.control.post(action, value)  # type: ignore[arg-type]
    assert len(stage.session.posts) == 5, "of a number the newest counts"
    while len(stage.session.posts):
        stage.frame()
    assert (
        stage.presenter.station is Station.ANSWERS
        and not stage.presenter.blank
        and stage.presenter.expected == 30
    )


def test_the_timer_runs_down_forces_nothing_and_ends_with_the_question(stage: Stage) -> None:
    presenter = stage.presenter
    assert presenter.left is None and presenter.asked_for is None
    # The time of a question that is not up yet brings it up.
    assert stage.act("timer 30") is Station.QUESTION and presenter.left == 30
    stage.frame(160)
    assert presenter.left == 20 and presenter.asked_for == 10
    stage.frame(480)
    assert presenter.left == 0
    stage.answer(2)
    poll = stage.control.poll()
    assert (
        poll is not None and poll.open and poll.tally.answered == 1 and presenter.station is Station.QUESTION
    )
    stage.act("timer 90", "timer off")
    assert presenter.left is None
    stage.act("timer 60", "reveal")
    assert presenter.left is None and presenter.asked_for is None
    # Nothing can be answered any more.
    stage.act("timer 60")
    assert presenter.left is None


def test_why_steps_do_not_open_stands_beside_those_that_are_open(
    stage: Stage, monkeypatch: pytest.MonkeyPatch
) -> None:
    notes: list[str] = []
    monkeypatch.setattr(teacher_panel, "PERIOD", 0.0)
    monkeypatch.setattr(teacher_panel, "macros", lambda _: Mock(note=notes.append))
    panel, stage.classroom.free = teacher_panel.BoardPanel(MagicMock(), stage.control), True
    for text in ("7", "2", "abc", ""):
        stage.control.post("pace", text)
        stage.frame()
        panel.show()
    no, only, every = (
        "Steps are written 2 or 2-3; this lesson has 1 to 3. Nothing opens all.",
        "Lesson 1: step 2 only.",
        "Every step is open.",
    )
    assert notes == [f"{no} {every}", only, f"{no} {only}", every] and not stage.session.notices


def test_a_student_who_is_away_for_a_moment_stays_chosen(
    stage: Stage, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(teacher_panel, "PERIOD", 0.0)
    monkeypatch.setattr(teacher_panel, "macros", MagicMock())
    gui, stage.classroom.free = MagicMock(), True
    student = gui.add_dropdown.return_value
    student.options, student.value = ("–",), "–"
    panel = teacher_panel.BoardPanel(gui, stage.control)
    seen: list[tuple[tuple[str, ...], str]] = []
    for here, chosen in (
        ("Euler Gauss", "Gauss"),
        ("Euler", ""),
        ("Euler Gauss", ""),
        ("Euler", "Euler"),
        ("Euler Noether", ""),
    ):
        rows = tuple(BoardRow(name, ()) for name in here.split())
        monkeypatch.setattr(stage.classroom.board, "rows", Mock(return_value=rows))
        panel.show()
        student.value = chosen or student.value
        seen.append((student.options, student.value))
    assert seen == [
        *[(("–", "Euler", "Gauss"), "Gauss")] * 3,
        (("–", "Euler", "Gauss"), "Euler"),
        (("–", "Euler", "Noether"), "Euler"),
    ]


def screen(stage: Stage, poll: Poll | None, station: Station, left: int | None = None) -> str:
    return screen_html(station, stage.lessons.walk.view(), poll, left, False)


def test_before_the_reveal_the_screen_says_only_how_many(stage: Stage) -> None:
    poll = stage.control.poll()
    assert poll is not None
    poll = replace(poll, tally=Tally((1, 2, 14, 0), 13, 17))
    asked = screen(stage, poll, Station.QUESTION, 45)
    assert "17 of 30 answered" in asked and ">0:45<" in asked and "14" not in asked and "82" not in asked
    assert asked.count("<li") == len(poll.choices) == 4 and asked.count("width:0%") == 4
    drawn = replace(poll, tally=Tally((1, 0, 0, 0), 0, 3, ((0.5,),) * 3))
    asked = screen(stage, drawn, Station.QUESTION, 45)
    assert "3 of 3 answered (1 chose, 3 drew)" in asked and "width:100%" in asked
    over = screen(stage, poll, Station.QUESTION, 0)
    assert "Time is up." in over and "until the reveal" in over
    told = screen(stage, replace(poll, open=False, revealed=True), Station.ANSWERS, 45)
    assert "width:82%" in told and "0:45" not in told and "right" not in told
    # Asked again, the first round stays out of sight until the second one is revealed beside it.
    second = replace(poll, first=Tally((3, 20, 5, 0), 2, 28), round=2)
    assert "Round" not in screen(stage, second, Station.QUESTION) and "71" not in screen(
        stage, second, Station.QUESTION
    )
    both = screen(stage, replace(second, open=False, revealed=True), Station.ANSWERS)
    assert "Round 1" in both and "width:71%" in both and "width:82%" in both
    # In the scene the count is there once there is something to count.
    assert "17 of 30" in screen(stage, poll, Station.SCENE)
    assert "answered" not in screen(stage, replace(poll, tally=Tally((0,) * 4, 0, 0)), Station.SCENE)
    known = replace(poll, open=False, revealed=True, outcome=("4 ways",), right=2)
    assert 'class="right"' in screen(stage, known, Station.OUTCOME) and "4 ways" in screen(
        stage, known, Station.OUTCOME
    )


def test_a_question_that_asks_for_a_curve_shows_its_axes_and_no_curve(stage: Stage) -> None:
    stage.lessons.act(
        GoTo(3, next(i for i, step in enumerate(BOOK.lessons[3].steps) if step.drawing is not None))
    )
    stage.frame()
    poll = stage.control.poll()
    assert poll is not None and poll.drawing is not None
    curve = tuple(0.5 for _ in range(COLUMNS))
    poll = replace(poll, tally=Tally((1, 0, 0, 0), 0, 1, (curve,)))
    asked, told = (
        screen(stage, poll, Station.QUESTION),
        screen(stage, replace(poll, revealed=True), Station.ANSWERS),
    )
    assert "<figure" in asked and "1 drawn" not in asked and "median" not in asked
    assert "1 drawn" in told and "median" in told


def test_no_text_of_a_step_names_a_plot_by_a_place_that_a_projector_does_not_have() -> None:
    elsewhere = re.compile(
        r"(second|other|left|right|lower|upper) plot|(zweite|andere|linke|rechte)\w* Diagramm|drug\w+ graf|formula below"
    )
    for language in LANGUAGES:
        for lesson in BOOK.in_language(language).lessons:
            for step in lesson.steps:
                asked = "" if step.question is None else step.question.text
                for text in (step.goal, asked, step.do, step.observe):
                    assert not elsewhere.search(text), (language, lesson.id, step.id, text)


def test_reasons_are_taken_after_the_vote_and_shown_as_picked(stage: Stage) -> None:
    walk, question = stage.lessons.walk, (BOOK.lessons[0].id, BOOK.lessons[0].steps[0].id)
    classroom, evil = stage.classroom, "<img src=x onerror=alert(1)>"
    classroom.give_reason(walk, "student 0", question, "before the vote")
    stage.answer(0, 2, 2)
    classroom.give_reason(walk, "student 9", question, "without a vote")
    classroom.give_reason(walk, "student 0", ("other", "question"), "of another question")
    assert not classroom.ballots.reasons(question)
    for student, reason in (
        ("student 2", f" {evil}\n\u202e" + "x" * 500),
        ("student 0", "first"),
        ("student 0", "second thoughts"),
    ):
        stage.control.answers.put(Because(student, question, reason))
        stage.control.answers.do()
    reasons = classroom.ballots.reasons(question)
    # A number stays with its ballot, and so does the reason when the answer is another one.
    assert (
        list(reasons) == [1, 3]
        and reasons[1] == (0, "second thoughts")
        and reasons[3][1] == f"{evil} {'x' * 171}"
    )
    assert classroom.answer(walk, "student 0", 1) and classroom.ballots.reasons(question)[1] == (
        1,
        "second thoughts",
    )
    stage.control.post("quote", "3, 1, 2, 77, no")
    stage.frame()
    assert stage.presenter.quotes == (reasons[3][1], "second thoughts")
    made = screen_html(
        Station.QUESTION, stage.lessons.walk.view(), stage.control.poll(), None, False, stage.presenter.quotes
    )
    assert "second thoughts" in made and "<img" not in made and "&lt;img" in made and "student" not in made
    # What is shown is what was picked, whatever its author writes then; after the reveal nothing is taken.
    classroom.give_reason(walk, "student 0", question, "something rude")
    stage.act("reveal")
    classroom.give_reason(walk, "student 0", question, "too late")
    assert (
        stage.presenter.quotes[1] == "second thoughts"
        and classroom.ballots.reasons(question)[1][1] == "something rude"
    )
    assert (
        classroom.hand_in(walk, "student 0", "", "")
        and "something rude" in classroom.work.hand_ins["student 0"].progress
    )
    # Asked again, and in another step, what was said before is no longer there.
    for change in (partial(stage.act, "again"), partial(stage.lessons.act, GoTo(3, 0))):
        stage.presenter.quotes = ("first",)
        change()
        stage.frame()
        assert stage.presenter.quotes == ()


def test_a_tie_is_compared_with_both(stage: Stage) -> None:
    stage.answer(0, 2)
    stage.act("on", "on")
    poll = stage.control.poll()
    assert poll is not None and poll.staged == (0, 2) and stage.lessons.walk.done.choice == 0
    assert "The run is compared with each of them." in poll_html(poll)
    # The one that is chosen in the shared session is not said to be the class's.
    assert ".mine" in tied_html(poll) and "card" not in tied_html(poll).partition("</style>")[2]
    stage.act("on")
    stage.frame(20)
    stage.act("on")
    stage.until(Station.OUTCOME)
    poll = stage.control.poll()
    assert poll is not None and poll.outcome and poll.right == 2
    cards = tied_html(poll).partition("</style>")[2]
    assert cards.count("The class said") == 2 and cards.count("card wrong") == cards.count("card right") == 1
    # The run that shows why the first one is wrong is about that one alone.
    if stage.lessons.walk.view().why:
        stage.lessons.act(Press("why"))
        stage.frame()
        poll = stage.control.poll()
        assert poll is not None and poll.staged == (0,) and tied_html(poll) == ""
