"""Challenges without a page: failed criteria are named, and a forecast has the unit of its question."""

from pathlib import Path

from app.features.lessons.panel.elbow_marks import reaches
from app.features.lessons.panel.lesson_html import attempt_html
from app.features.lessons.session import lesson_actions as do
from app.features.lessons.session.lesson_session import LessonSession
from app.session.session import Session
from app.settings import Settings
from tests.app.features.lessons.helpers import SMALL, book_of, to_challenge
from tests.app.features.lessons.student import BOOK, Student


def test_a_challenge_names_failures_and_keeps_the_students_settings() -> None:
    one = Student(0, 2)
    session, run = one.session, one.run
    assert reaches(run.walk.step) == (0.015, 0.015) and reaches(BOOK.lessons[0].steps[0]) == (), (
        "only the step with marks has distances to reach"
    )
    one.to_challenge()
    assert run.walk.yours and not run.hands_off and not session.paused
    run.act(do.Press("check"))
    assert "Press Run first." in attempt_html(run.walk.view())
    shown = run.version
    one.frame()
    assert run.version > shown and attempt_html(run.walk.view()) == "", (
        "the message disappears when the run begins"
    )
    for _ in range(40):
        one.frame()
    run.act(do.Press("check"))
    attempt = run.walk.done.last
    assert attempt is not None and not attempt.passed and attempt.failed
    assert any("must be" in j.text for j in attempt.judgements)
    run.act(do.Press("hint"))
    assert len(run.walk.view().hints) == 1
    session.change("k", 5.0)
    session.change("dt", 0.005)
    one.frame()
    run.act(do.Press("check"))
    attempt = run.walk.done.last
    assert attempt is not None and not attempt.passed and attempt.note, (
        "a change of settings during the run does not count"
    )
    run.act(do.Press("again"))
    assert session.simulation.steps == 0 and session.settings.run.gain == 5.0 and not session.paused
    one.swing()
    run.act(do.Press("check"))
    assert run.walk.done.passed, run.walk.done.last
    run.act(do.Press("reset"))
    run.act(do.Press("next"))
    assert session.settings.run.gain == run.walk.setup.run.gain != 5.0


def test_a_forecast_is_entered_in_the_unit_of_its_question(tmp_path: Path) -> None:
    asked = """[[challenge.forecast]]
id = "near"
name = "smallest_distance"
unit = "mm"
settings = { n = 6.0 }

[[attempt]]
name = "right"
forecasts = ["d"]
fails = ["near"]
"""
    criterion = SMALL[SMALL.index("[[challenge.criterion]]") : SMALL.index("```\n\n### Goal")]
    book = book_of(tmp_path, SMALL.replace(criterion, asked))
    assert not book.problems
    run = LessonSession(Session(Settings()), book)
    run.enter(0, 0)
    to_challenge(run.walk)
    here = run.walk.lesson.id, run.walk.step.id
    # A number typed in another step goes to that step, however late it arrives.
    run.act(do.SayNumber(here[0], "another", 0, 7.0))
    assert run.said == []
    run.act(do.SayNumber(*here, 0, 1.0))
    run.runner.further.result(60.0)
    run.act(do.Press("check"))
    said = run.walk.done.last
    assert (
        said is not None
        and said.judgements[0].value is not None
        and "you said 1.0 mm" in said.judgements[0].text
    )
    run.act(do.SayNumber(*here, 0, 1000.0 * said.judgements[0].value))
    run.act(do.Press("check"))
    assert run.walk.done.passed
