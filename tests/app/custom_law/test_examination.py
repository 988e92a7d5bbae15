"""A student's law on the page, without a browser: tested beside it, as the law, as the ghost, and resting until its turn in the lessons."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from app.custom_law import examination as examination_module
from app.custom_law.examination import NO_FILE, Examination, ExaminationProgress
from app.custom_law.trial_result import TrialResult
from app.custom_law.trials import TRIALS, WHY
from app.lessons.loading import load_lessons
from app.lessons.phases import Phase
from app.lessons.session.lesson_actions import Check, GoBack, GoOn
from app.lessons.session.lesson_session import LessonSession
from app.page.lessons.custom_law_html import law_html
from app.runtime.job_pool import BUSY, JobPool
from app.session.session import Session
from app.settings import Settings
from controllers.errors import BadInputFile
from scenes.settings import changed
from tests.app.custom_law.helpers import PAPER, session_of, write
from tests.app.inline import Inline
from tests.app.runtime.processes import until

NAMES = tuple(TRIALS)
STANDS_STILL = "def law(s):\n    return 0.0 * s.nominal"


def names_it(path: Path, text: bytes, name: str, stopped: Callable[[], bool]) -> TrialResult:
    assert path.name == "my_law.py" and not stopped()
    return TrialResult(name, name.encode() in text, f"{name} is named", {})


def test_verdicts_come_in_order_and_on_the_text_as_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(examination_module, "examine_one", names_it)
    path, background = write(tmp_path / "my_law.py", "# " + ", ".join(NAMES[:-1])), Inline()
    examination = Examination(path, background, lambda: None)
    assert examination.progress == ExaminationProgress("my_law.py") and not examination.advance()
    examination.begin()
    write(path, "# " + ", ".join(NAMES))
    for count, name in enumerate(NAMES):
        assert examination.progress.running and not examination.progress.finished
        assert [v.name for v in examination.progress.verdicts] == list(NAMES[:count]) and not examination.advance()
        assert background.work(name) == [name]
        assert examination.advance()
    assert examination.progress.finished and not examination.progress.running and not examination.advance()
    assert [v.passed for v in examination.progress.verdicts] == [True] * 5 + [False]
    examination.begin()
    background.work()
    assert examination.advance() and all(v.passed for v in examination.progress.verdicts)


def test_tests_that_cannot_be_made_say_why(tmp_path: Path) -> None:
    path, background = write(tmp_path / "my_law.py", "def law(s):\n    return s.nominal"), Inline()
    examination = Examination(path, background, lambda: None)
    examination.begin()
    examination.drop()
    assert examination.progress == ExaminationProgress("my_law.py") and {job.state for job in background.jobs} == {"dropped"}
    closed = JobPool(1)
    closed.close()
    examination = Examination(path, closed, lambda: None)
    examination.begin()
    assert examination.advance() and not examination.progress.running and examination.progress.message == BUSY
    path.unlink()
    with pytest.raises(BadInputFile, match="new-law"):
        examination.begin()


def test_it_is_the_law_or_the_ghosts(tmp_path: Path) -> None:
    path = write(tmp_path / "my_law.py", STANDS_STILL)
    with session_of(path, scene="ball") as session:

        def moves() -> tuple[bool, bool]:
            session.advance(0.02)
            assert session.ghost is not None
            joints = session.simulation.avoiding.joints
            return bool(np.any(session.simulation.velocities[joints])), bool(np.any(session.ghost.velocities[joints]))

        session.change("ghost", "smooth_priority")
        assert (session.student_law.file, session.student_law.ghost_file) == ("my_law.py", None)
        until(lambda: moves() == (False, True))
        session.change("ghost", "own")
        assert (session.student_law.file, session.student_law.ghost_file) == (None, "my_law.py")
        assert session.simulation.steps == 0
        until(lambda: moves() == (True, False))
        assert session.student_law.problem == ""
        write(path, "def law(s):\n    return s.nominal / 0 + nothing")
        until(lambda: moves() and session.student_law.problem)
        assert "line 2: NameError" in session.student_law.problem and moves() == (True, False)
        write(path, PAPER)
        until(lambda: moves() == (True, True))
        assert session.student_law.problem == ""
        session.change("ghost", "off")
        assert (session.student_law.file, session.student_law.ghost_file) == ("my_law.py", None)


def test_without_a_file() -> None:
    session = Session(changed(Settings(), "ghost", "own"))
    assert session.student_law.ghost_file is None and session.ghost is not None and session.law.examination is None
    for _ in range(20):
        session.advance(0.02)
    assert np.array_equal(session.ghost.positions, session.simulation.positions)
    session = Session(Settings())
    run = LessonSession(session, load_lessons())
    to_challenge(session, run)
    assert run.own_tests == NO_FILE
    run.act(Check())
    run.decide()
    assert run.walk.done.attempts == 0 and run.own_tests == NO_FILE


def to_challenge(session: Session, run: LessonSession) -> None:
    run.enter("limits", 4)
    while run.walk.phase is not Phase.CHALLENGE:
        run.act(GoOn())
        session.advance(0.0)
        run.decide()


def test_in_lessons_it_rests_until_its_turn(tmp_path: Path) -> None:
    with session_of(write(tmp_path / "my_law.py", STANDS_STILL)) as session:
        run = LessonSession(session, load_lessons())
        assert session.student_law.file == "my_law.py" and run.own_tests is None
        run.enter("limits", 4)
        assert session.student_law.file is None and run.own_tests is None
        to_challenge(session, run)
        assert session.student_law.file == "my_law.py"
        while run.walk.phase is not Phase.DO:
            assert session.student_law.file == "my_law.py"
            run.act(GoBack())
        assert session.student_law.file is None
        to_challenge(session, run)
        run.leave()
        assert session.student_law.file == "my_law.py" and run.own_tests is None


def test_the_challenge_is_passed_by_six_tests(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(examination_module, "examine_one", names_it)
    background = Inline()
    path = write(tmp_path / "my_law.py", "# " + ", ".join(NAMES[1:]))
    with session_of(path, background) as session:
        run = LessonSession(session, load_lessons())
        to_challenge(session, run)
        assert run.own_tests == ExaminationProgress("my_law.py")

        def check() -> None:
            until(lambda: run._runs.ready)
            run.act(Check())
            for name in NAMES:
                background.work(name)
                run.decide()
            assert run.own_tests is not None and run.own_tests.finished

        until(lambda: run._runs.ready)
        run.act(Check())
        check()
        assert run.walk.done.attempts == 1 and not run.walk.done.passed
        attempt = run.walk.done.last
        assert attempt is not None and attempt.failed == NAMES[:1] and attempt.text.endswith("is named")
        assert WHY[NAMES[0]] in attempt.text
        write(path, "# " + ", ".join(NAMES))
        check()
        assert run.walk.done.attempts == 2 and run.walk.done.passed


def test_every_test_says_how_it_went_in_words() -> None:
    verdicts = tuple(TrialResult(name, name != NAMES[1], f"d < {i} mm & so on", {}) for i, name in enumerate(NAMES))
    before = law_html(ExaminationProgress("a<b>.py"), "", False, False)
    assert "a&lt;b&gt;.py runs." in before and all(WHY[name] in before for name in NAMES)
    middle = law_html(ExaminationProgress("my_law.py", verdicts[:3], True), "line 2: <script>", False, False)
    assert "&lt;script&gt;" in middle and "its arm stands still" in middle and 'role="status"' in middle
    for word, count in ((">passed<", 2), (">failed<", 1), (">being tested<", 1), (">waits<", 2)):
        assert middle.count(word) == count
    assert "Test 4 of 6" in middle and "d &lt; 1 mm &amp; so on" in middle and WHY[NAMES[1]] in middle
    end = law_html(ExaminationProgress("my_law.py", verdicts), "", False, False)
    assert "5 of 6 tests passed." in end and "card wrong" in end and "Challenge passed." not in end
    assert "Challenge passed." in law_html(ExaminationProgress("my_law.py", verdicts), "", False, True)
    assert "my_law.py is gone." in law_html(ExaminationProgress("my_law.py"), "", True, False)
    assert "&lt;no" in law_html(ExaminationProgress("my_law.py", message="<no"), "", False, False)
