"""Lesson cases of the core's `test_trials.py`."""

from pathlib import Path

import numpy as np
import pytest

from app.features.custom_law import examination as examination_module
from app.features.custom_law.examination import ExaminationProgress
from app.features.custom_law.law_html import COMMANDS
from app.features.custom_law.student_law import examination, take_law_file
from app.features.custom_law.trials import WHY
from app.features.lessons.bookmark import Phase
from app.features.lessons.loading import load_lessons
from app.features.lessons.session.lesson_actions import Press
from app.features.lessons.session.lesson_session import LessonSession
from app.session.session import Session
from app.settings import Settings
from scenes.settings import changed
from tests.app.conftest import Arrive, OpenHouse
from tests.app.features.custom_law.helpers import session_of, write
from tests.app.features.custom_law.test_trials import NAMES, STANDS_STILL, names_it
from tests.app.features.lessons.helpers import lessons_of
from tests.app.inline import Inline
from tests.app.page.helpers import buttons, shown
from tests.app.runtime.processes import until


def test_without_a_file() -> None:
    session = Session(changed(Settings(), "ghost", "own"))
    assert (
        session.law_status.ghost_file is None and session.ghost is not None and examination(session) is None
    )
    for _ in range(20):
        session.advance(0.02)
    assert np.array_equal(session.ghost.positions, session.simulation.positions)
    session = Session(Settings())
    run = LessonSession(session, load_lessons())
    to_challenge(session, run)
    assert run.own_tests == ExaminationProgress()
    run.act(Press("check"))
    run.decide()
    assert run.walk.done.attempts == 0 and run.own_tests == ExaminationProgress()


def test_without_a_file_the_step_shows_the_commands(house: OpenHouse, arrive: Arrive) -> None:
    guest = arrive(house(), "lesson=10&step=5")
    guest.ask(lambda session: to_challenge(session, lessons_of(guest)))
    guest.visitor.wait_for(
        lambda v: "Hint 1 of" in " ".join(buttons(v)) and all(command in shown(v) for command in COMMANDS)
    )
    assert "Test my law" not in buttons(guest.visitor)


def to_challenge(session: Session, run: LessonSession) -> None:
    run.enter("limits", 4)
    while run.walk.phase is not Phase.CHALLENGE:
        run.act(Press("next"))
        session.advance(0.0)
        run.decide()


def test_lessons_use_the_custom_law_only_in_its_challenge(tmp_path: Path) -> None:
    with session_of(write(tmp_path / "my_law.py", STANDS_STILL)) as session:
        run = LessonSession(session, load_lessons())
        assert session.law_status.file == "my_law.py" and run.own_tests is None
        run.enter("limits", 4)
        assert session.law_status.file is None and run.own_tests is None
        to_challenge(session, run)
        assert session.law_status.file == "my_law.py"
        while run.walk.phase is not Phase.DO:
            assert session.law_status.file == "my_law.py"
            run.act(Press("back"))
        assert session.law_status.file is None
        to_challenge(session, run)
        run.leave()
        assert session.law_status.file == "my_law.py" and run.own_tests is None


def test_the_challenge_is_passed_by_six_tests(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(examination_module, "examine_one", names_it)
    background = Inline()
    path = write(tmp_path / "my_law.py", "# " + ", ".join(NAMES[1:]))
    with session_of(path, background) as session:
        run = LessonSession(session, load_lessons())
        to_challenge(session, run)
        assert run.own_tests == ExaminationProgress("my_law.py")

        def check() -> None:
            until(lambda: run.runner.further.done())
            run.act(Press("check"))
            for name in NAMES:
                background.work(name)
                session.law.advance(0.0, paused=False)
                run.decide()
            assert run.own_tests is not None and run.own_tests.finished

        until(lambda: run.runner.further.done())
        run.act(Press("check"))
        check()
        assert run.walk.done.attempts == 1 and not run.walk.done.passed
        attempt = run.walk.done.last
        assert attempt is not None and attempt.failed == NAMES[:1] and attempt.text.endswith("is named")
        assert WHY[NAMES[0]] in attempt.text
        write(path, "# " + ", ".join(NAMES))
        check()
        assert run.walk.done.attempts == 2 and run.walk.done.passed


def test_tests_that_begin_and_end_within_a_frame_count_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """This happens after a text was saved in the editor."""
    monkeypatch.setattr(examination_module, "examine_one", names_it)
    background = Inline()
    path = write(tmp_path / "my_law.py", "# " + ", ".join(NAMES))
    with session_of(path, background) as session:
        run = LessonSession(session, load_lessons())
        to_challenge(session, run)
        until(lambda: run.runner.further.done())
        for attempts in (1, 2):
            take_law_file(session, path)
            tests = examination(session)
            assert tests is not None
            tests.begin()
            background.work()
            session.law.advance(0.0, paused=False)
            for _ in range(2):
                run.decide()
                assert run.walk.done.attempts == attempts and run.walk.done.passed
