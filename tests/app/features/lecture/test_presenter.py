"""The projector without a page: stations of a lesson, clicker, covers, timer and board."""

import itertools
import re
from unittest.mock import MagicMock, Mock

import pytest

from app.features.classroom.classroom_html import poll_html, tied_html
from app.features.classroom.student_work import BoardRow
from app.features.lecture import teacher_panel
from app.features.lecture.presenter import Station, stations_of
from app.features.lecture.screen_panel import covers_html, next_station_label
from app.features.lessons.bookmark import Phase
from app.features.lessons.session.lesson_actions import Choose, GoTo, Press
from tests.app.features.lecture.presenter_stage import BOOK, Stage, screen
from tests.approved import Approve, shown_text


def test_a_clicker_goes_through_a_step_and_back(stage: Stage) -> None:
    walk = stage.lessons.walk
    assert stage.presenter.station is Station.SCENE and stations_of(walk)[:4] == tuple(Station)[:4]
    assert stage.act("on") is Station.QUESTION and stage.session.paused
    # Without an answer there is nothing to reveal; the lesson asks for a prediction.
    stage.session.notices.clear()
    assert stage.act("on") is Station.QUESTION and stage.session.notices[0][0] == "Predict first"
    stage.answer(0, 2, 2)
    assert stage.act("on") is Station.ANSWERS
    poll = stage.control.poll()
    assert poll is not None and poll.revealed and stage.session.paused and walk.phase is Phase.DO
    assert stage.act("on") is Station.RUN and not stage.session.paused
    stage.frame(20)
    # Back to the answers, which stay revealed; the run waits and can continue.
    assert (
        stage.act("back") is Station.ANSWERS and stage.session.paused and stage.session.simulation.steps > 0
    )
    # Back from the answers to the question, which does not show them.
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
    # The next press ends the run, and the outcome follows by itself.
    stage.act("on")
    stage.until(Station.OUTCOME)
    poll = stage.control.poll()
    assert poll is not None and poll.outcome
    stations = [stage.act("on") for _ in range(4)]
    assert stations == [Station.EXPLANATION, Station.CHALLENGE, Station.TRY, Station.SCENE]
    assert walk.step_index == 1
    assert stage.act("back") is Station.CHALLENGE and walk.step_index == 0
    assert [stage.act("back") for _ in range(3)] == [Station.EXPLANATION, Station.OUTCOME, Station.RUN]


def test_the_projector_follows_the_teachers_other_actions(stage: Stage) -> None:
    stage.answer(1, 1)
    stage.act("on")
    assert stage.act("reveal") is Station.ANSWERS
    # *Ask again* shows the question again.
    assert stage.act("again") is Station.QUESTION
    # The teacher answers for the class, then presses Run.
    stage.lessons.act(Choose(1))
    assert stage.frame() is Station.RUN and stage.session.paused
    assert stage.act("back") is Station.QUESTION
    stage.lessons.act(Press("run"))
    assert stage.frame() is Station.RUN and not stage.session.paused
    stage.lessons.act(GoTo(3, 1))
    assert stage.frame() is Station.SCENE
    stage.lessons.leave()
    assert stage.frame() is Station.SCENE and stage.act("on") is Station.SCENE


def test_the_stations_of_every_step_lead_to_the_next_step(stage: Stage) -> None:
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


def test_a_page_key_first_uncovers_the_picture(stage: Stage) -> None:
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


def test_the_teacher_reads_the_cover_of_the_screen_and_the_timer(stage: Stage, approve: Approve) -> None:
    presenter, said = stage.presenter, list[str]()
    for action in ("blank", "live", "freeze", "live", "invite", "invite all", "hide", "timer 30"):
        stage.act(action)
        said.append(f"# {action}\n{shown_text(covers_html(presenter))}")
    stage.frame(480)
    assert presenter.left == 0
    approve(
        "covers of the screen.txt", "".join([*said, f"# 30 s later\n{shown_text(covers_html(presenter))}"])
    )


def test_two_presses_within_one_frame_count_as_two(stage: Stage) -> None:
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
    assert len(stage.session.posts) == 5, "only the newest number is kept"
    while len(stage.session.posts):
        stage.frame()
    assert (
        stage.presenter.station is Station.ANSWERS
        and not stage.presenter.blank
        and stage.presenter.expected == 30
    )


def test_the_timer_closes_nothing_and_ends_with_the_question(stage: Stage) -> None:
    presenter = stage.presenter
    assert presenter.left is None and presenter.asked_for is None
    # A timer shows the question if it is not shown yet.
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
    # Answers are closed: no timer starts.
    stage.act("timer 60")
    assert presenter.left is None


def test_the_reason_for_refused_steps_is_shown_with_the_open_steps(
    stage: Stage, monkeypatch: pytest.MonkeyPatch, approve: Approve
) -> None:
    notes: list[str] = []
    monkeypatch.setattr(teacher_panel, "PERIOD", 0.0)
    monkeypatch.setattr(teacher_panel, "macros", lambda _: Mock(note=notes.append))
    panel, stage.classroom.free = teacher_panel.BoardPanel(MagicMock(), stage.control), True
    for text in ("7", "2", "abc", ""):
        stage.control.post("pace", text)
        stage.frame()
        panel.show()
    approve("open steps.txt", "\n".join(notes) + "\n")
    assert not stage.session.notices


def test_a_briefly_absent_student_stays_chosen(stage: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
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


def said_of(poll: str) -> str:
    """Lines below the bars, without the lesson's texts."""
    return "".join(map(shown_text, re.findall(r'<p class="said">.*?</p>', poll, re.DOTALL)))


def test_a_tie_is_compared_with_both(stage: Stage, approve: Approve) -> None:
    stage.answer(0, 2)
    stage.act("on", "on")
    poll = stage.control.poll()
    assert poll is not None and poll.staged == (0, 2) and stage.lessons.walk.done.choice == 0
    approve("tie.txt", said_of(poll_html(poll)))
    # The answer chosen in the shared session is not marked as the class's.
    assert ".mine" in tied_html(poll) and "card" not in tied_html(poll).partition("</style>")[2]
    stage.act("on")
    stage.frame(20)
    stage.act("on")
    stage.until(Station.OUTCOME)
    poll = stage.control.poll()
    assert poll is not None and poll.outcome and poll.right == 2
    cards = tied_html(poll).partition("</style>")[2]
    assert cards.count("The class said") == 2 and cards.count("card wrong") == cards.count("card right") == 1
    # The contrast run concerns only the wrong answer.
    if stage.lessons.walk.view().why:
        stage.lessons.act(Press("why"))
        stage.frame()
        poll = stage.control.poll()
        assert poll is not None and poll.staged == (0,) and tied_html(poll) == ""
