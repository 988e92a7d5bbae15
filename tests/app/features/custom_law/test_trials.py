"""The tests of a custom law with their failures and messages; the law as law, as ghost, and at rest."""

import math
import re
import shlex
import textwrap
from collections.abc import Callable
from contextlib import closing
from functools import cache
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

from app.features.custom_law import examination as examination_module
from app.features.custom_law import template
from app.features.custom_law.arena import TrialResult
from app.features.custom_law.commands import LawTest, NewLaw, law_test, new_law
from app.features.custom_law.examination import Examination, ExaminationProgress, examine, examine_one
from app.features.custom_law.law_file import LawFile
from app.features.custom_law.law_html import law_html
from app.features.custom_law.law_limits import LawProblem
from app.features.custom_law.student_law import examination as examination_of
from app.features.custom_law.trials import TRIALS, verdict_on
from app.i18n.speaking import set_language
from app.runtime.job_pool import BUSY, JobPool
from app.settings import LANGUAGES, Language
from controllers.errors import BadInputFile, BadSetting, LazyText
from controllers.kinematics import Array
from controllers.laws.situation import Law, Situation
from scenes import wanted
from scenes.settings import LawSettings
from tests.app.features.custom_law.helpers import PAPER, received, session_of, situation, write
from tests.app.features.said import lines_of, without_numbers
from tests.app.inline import Inline
from tests.app.runtime.processes import until
from tests.approved import Approve, shown_text

KEEPS, ALONE, OUT, SMOOTH, BOUNDED, QUICK = TRIALS


class Candidate:
    """A law in this process, with the built-in law's answers to what the tests do not check."""

    wants_all_pairs: ClassVar[bool] = True
    wants_task: ClassVar[bool] = True
    problem: LawProblem | None = None
    seconds = 1e-5

    def __init__(self, built_in: Law, own: Callable[[Situation], Array] | None = None) -> None:
        self.activation, self.line_rate, self._law = built_in.activation, built_in.line_rate, own or built_in

    def __call__(self, situation: Situation) -> Array:
        return self._law(situation)


def built_in(name: str = "smooth_priority", **settings: Any) -> Candidate:
    return Candidate(LawSettings(law=name, **settings).made())


def from_text(text: str) -> Candidate:
    file = LawFile("my_law.py", textwrap.dedent(text).encode(), 2**28)
    return Candidate(LawSettings().made(), lambda situation: file.velocities(received(situation))[0])


@cache
def verdicts_of(name: str) -> dict[str, TrialResult]:
    """Verdicts on a built-in law (read-only)."""
    law = built_in(name)
    return {test: verdict_on(law, test) for test in TRIALS}


def parts_of(verdict: TrialResult) -> dict[str, Any]:
    """Parts of the text with a verdict's reason."""
    assert isinstance(verdict.reason, LazyText)
    return verdict.reason.parts


def metres(text: str) -> float:
    return float(text.removesuffix(" mm").replace("−", "-")) / 1e3


def failed(verdicts: list[TrialResult]) -> set[str]:
    assert [verdict.name for verdict in verdicts] == list(TRIALS)
    return {verdict.name for verdict in verdicts if not verdict.passed}


SWITCHED = """
    def law(s):
        if s.distance > 0.15:
            return s.nominal
        return s.nominal + s.row * (0.30 + s.pull) / (s.row @ s.row + 0.06**2)
"""
TASK_ONLY = "def law(s):\n    return s.nominal"


def test_a_switched_and_an_unprotected_law_fail_the_expected_tests() -> None:
    law, unprotected = from_text(SWITCHED), verdicts_of("unprotected")
    verdicts = [verdict_on(law, test) for test in TRIALS]
    assert failed(verdicts) == {SMOOTH}, verdicts
    for verdict in (*verdicts, *unprotected.values()):
        assert verdict.passed == ("fails" not in verdict.reason) and (
            "≤" in verdict.reason or "≥" in verdict.reason
        )
        assert all(math.isfinite(part) for part in parts_of(verdict).values() if isinstance(part, float))
    assert "fails by 184." in unprotected[KEEPS].reason and "fails by 201." in unprotected[OUT].reason


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_reason_uses_names_and_numbers_of_its_language(language: Language, approve: Approve) -> None:
    laws = {
        "switched": verdict_on(from_text(SWITCHED), SMOOTH),
        "alone": verdict_on(built_in(order=1.0), ALONE),
    }
    verdicts = {**verdicts_of("unprotected"), **laws}
    said = lines_of({case: verdict.reason for case, verdict in verdicts.items()}, language)
    assert language == "en" or not re.search(r"\d\.\d", said)
    approve(f"reasons {language}.txt", without_numbers(said))


@pytest.mark.thorough
def test_tests_run_in_other_processes_and_can_be_stopped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # The tests use the text from the start of the examination, even if the file changes meanwhile.
    monkeypatch.setattr(examination_module, "TRIALS", {OUT: TRIALS[OUT]})
    path = write(tmp_path / "my_law.py", TASK_ONLY)
    with closing(JobPool(1)) as background:
        examination = Examination(path, background, lambda: None)
        examination.begin()
        write(path, "def law(s):\n    return s.nominal * 0")
        until(examination.advance)
    assert examination.progress.verdicts == (verdicts_of("unprotected")[OUT],)
    asked = 0

    def stopped() -> bool:
        nonlocal asked
        asked += 1
        return asked > 30

    path = write(tmp_path / "my_law.py", TASK_ONLY)
    with pytest.raises(wanted.Stopped), wanted.until(stopped):
        examine_one(path, path.read_bytes(), KEEPS)
    assert asked == 31


def test_a_new_law_is_the_papers_and_unbounded_where_j_d_is_singular(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "her_law.py"
    assert new_law(NewLaw(path)) == 0
    assert "lwr-duet law-test" in capsys.readouterr().out
    text = path.read_text(encoding="utf-8")
    assert "law-test her_law.py" in text and "my_law.py" not in text
    # The other three test the same law in this process below; through another process they are slow.
    monkeypatch.setattr(
        "app.features.custom_law.examination.TRIALS", {name: TRIALS[name] for name in (OUT, BOUNDED, QUICK)}
    )
    assert law_test(LawTest(path)) == 1
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 4 and "2 of 3" in lines[-1]
    assert [line[:4] for line in lines[:-1]] == ["pass", "FAIL", "pass"]
    assert BOUNDED in lines[1] and "fails by" in lines[1]
    # Renamed variables give the template's answers; stronger damping does not.
    renamed = text.replace("    c = ", "    print(lam)\n    rate = ").replace("J_d * c", "J_d * rate")
    for own, same in ((renamed, True), (text.replace("MU = 0.01", "MU = 0.06"), False)):
        (verdict,) = examine(path, only=(BOUNDED,), text=own.encode())
        assert own != text and (verdict.as_template, verdict.passed) == (same, not same)


FAILED: dict[str, set[str]] = {
    "smooth_priority": set(),
    "strict_priority": {ALONE},
    "strict_switched": {SMOOTH},
    "barrier_qp": {KEEPS},
    "null_space_avoidance": {KEEPS, OUT},
    "potential_field": {OUT, BOUNDED},
    "intermediate_value": {BOUNDED},
    "task_activation": {BOUNDED},
    "continuous_inverse": {KEEPS, OUT, BOUNDED},
    "set_based_task": {KEEPS, SMOOTH, BOUNDED},
    "unprotected": {KEEPS, OUT},
}


@pytest.mark.thorough
@pytest.mark.parametrize(("name", "failures"), FAILED.items())
def test_failures_of_the_built_in_laws(name: str, failures: set[str]) -> None:
    assert failed(list(verdicts_of(name).values())) == failures


def test_numbers_of_the_built_in_laws() -> None:
    # With the hand's speed the barrier keeps d_m; the paper's law with n = 1 disturbs the task from afar.
    assert (
        verdict_on(built_in("barrier_qp", feed_forward=True), KEEPS).passed
        and not verdicts_of("barrier_qp")[KEEPS].passed
    )
    flat = built_in(order=1.0)
    early, out, bounded = (verdict_on(flat, test) for test in (ALONE, OUT, BOUNDED))
    assert not early.passed and re.search(r"\b7\d*(\.\d+)? mm", early.reason)
    assert out.passed and bounded.passed
    # The hand rests where λ (v + u) = u; leaving overlap takes (d_m − d) / v; the whole of a jump remains.
    paper = verdicts_of("smooth_priority")
    parts = parts_of(paper[ALONE])
    # K |e| ≈ u, except the angle between the row and the hand's path; 1.5 s is too short to settle fully.
    lam = (0.15 / metres(parts["d"])) ** 6
    assert metres(parts["error"]) == pytest.approx(lam * 0.3 / 2.0, rel=0.2)
    parts = parts_of(paper[OUT])
    assert parts["time"] == pytest.approx((0.15 - metres(parts["start"])) / 0.3, abs=0.03)
    assert parts_of(paper[SMOOTH])["share"] == pytest.approx(0.5, abs=0.02)
    assert parts_of(verdicts_of("strict_switched")[SMOOTH])["share"] == pytest.approx(1.0, abs=0.02)
    # All digits agree where J_d is regular, with the same λ.
    paper, there = LawSettings().made(), situation()
    assert [template.activation(d) for d in (0.1, 0.2, math.inf)] == [
        paper.activation(d) for d in (0.1, 0.2, math.inf)
    ]
    np.testing.assert_allclose(template.law(there), paper(there), rtol=1e-3)


def test_laws_that_fail_and_files_that_cannot_be_loaded(tmp_path: Path) -> None:
    # An exception in overlap fails the three tests that reach it, with its line; other tests restart.
    text = PAPER + "    def guard(d):\n        if d < 0:\n            raise ValueError('overlap')\n"
    text = text.replace("        c = ", "        guard(situation.distance)\n        c = ")
    verdicts = list(examine(write(tmp_path / "my_law.py", text), only=(OUT, ALONE, BOUNDED, QUICK)))
    assert [verdict.passed for verdict in verdicts] == [False, True, False, False]
    for verdict in verdicts:
        if not verdict.passed:
            assert "line 13: ValueError" in verdict.reason
            assert verdict.curve is None, "a single sample gives no curve"
    text = "calls = []\ndef law(s):\n    calls.append(1)\n    return s.nominal / (len(calls) < 3)\n"
    kept, empty = examine(write(tmp_path / "my_law.py", text), only=(KEEPS, ALONE))
    assert kept.curve is not None and empty.curve is None, "d = ∞ gives no curve"
    verdicts = list(examine(write(tmp_path / "my_law.py", "def law(s)\n")))
    assert failed(verdicts) == set(TRIALS)
    (reason,) = {verdict.reason for verdict in verdicts}
    assert "line 1: SyntaxError" in reason
    with pytest.raises(BadInputFile, match="no such file"):
        list(examine(tmp_path / "other.py"))


def test_a_slow_law_is_named_and_does_not_delay_the_other_tests(approve: Approve) -> None:
    """2 ms per call: too slow. 60 ms per call: the runs end after 10 s of calls."""
    law = built_in()
    law.seconds = 0.002
    verdicts = [verdict_on(law, test) for test in (OUT, QUICK)]
    assert [verdict.passed for verdict in verdicts] == [True, False]
    approve("slow law.txt", f"{verdicts[-1].reason}\n")
    law.seconds = 0.06
    verdicts = [verdict_on(law, test) for test in TRIALS]
    assert failed(verdicts) == {KEEPS, SMOOTH, OUT, ALONE, QUICK}
    assert "a call takes 60 ms" in verdicts[0].reason


def test_nothing_is_overwritten_and_names_are_quoted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write(tmp_path / "my_law.py", "mine")
    for there, says in (
        (path, "is there already"),
        (tmp_path, "is there already"),
        (tmp_path / "no" / "my_law.py", "cannot be"),
    ):
        with pytest.raises(BadSetting, match=says):
            new_law(NewLaw(there))
    assert path.read_text(encoding="utf-8") == "mine"
    path = tmp_path / "Ana's law_$1.py"
    assert new_law(NewLaw(path)) == 0
    said = capsys.readouterr().out
    assert shlex.split(said.split("Next: ")[1])[:3] == ["lwr-duet", "law-test", f"{path},"]
    assert shlex.split(path.read_text(encoding="utf-8").splitlines()[3])[3] == path.name


NAMES = tuple(TRIALS)
STANDS_STILL = "def law(s):\n    return 0.0 * s.nominal"


def names_it(path: Path, text: bytes, name: str) -> TrialResult:
    assert path.name == "my_law.py"
    return TrialResult(name, name.encode() in text, f"{name} is named")


def test_verdicts_come_in_order_and_refer_to_the_original_text(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(examination_module, "examine_one", names_it)
    path, background = write(tmp_path / "my_law.py", "# " + ", ".join(NAMES[:-1])), Inline()
    examination = Examination(path, background, lambda: None)
    assert examination.progress == ExaminationProgress("my_law.py") and not examination.advance()
    examination.begin()
    write(path, "# " + ", ".join(NAMES))
    for count, name in enumerate(NAMES):
        assert examination.progress.running and not examination.progress.finished
        assert [v.name for v in examination.progress.verdicts] == list(
            NAMES[:count]
        ) and not examination.advance()
        assert background.work(name) == [name]
        assert examination.advance()
    assert examination.progress.finished and not examination.progress.running and not examination.advance()
    assert [v.passed for v in examination.progress.verdicts] == [True] * 5 + [False]
    examination.begin()
    background.work()
    assert examination.advance() and all(v.passed for v in examination.progress.verdicts)


def test_results_are_stale_while_the_file_has_another_text(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(examination_module, "examine_one", names_it)
    path, background = write(tmp_path / "my_law.py", PAPER), Inline()
    with session_of(path, background) as session:
        tests = examination_of(session)
        assert tests is not None

        def stale() -> bool:
            session.advance(0.02)
            return tests.progress.stale

        tests.begin()
        assert not stale()
        background.work()
        until(lambda: not stale() and tests.progress.finished)
        write(path, STANDS_STILL)
        until(stale)
        # Its results are kept, for the text that they are of.
        assert len(tests.progress.verdicts) == len(NAMES)
        write(path, PAPER)
        until(lambda: not stale())
        write(path, STANDS_STILL)
        until(stale)
        tests.begin()
        assert not stale()
        background.work()
        until(lambda: not stale() and tests.progress.finished)


def test_tests_that_cannot_run_give_a_reason(tmp_path: Path) -> None:
    path, background = write(tmp_path / "my_law.py", "def law(s):\n    return s.nominal"), Inline()
    examination = Examination(path, background, lambda: None)
    examination.begin()
    number = examination.progress.number
    examination.drop()
    assert number > 0 and examination.progress == ExaminationProgress("my_law.py", number=number)
    assert {job.state for job in background.jobs} == {"dropped"}
    closed = JobPool(1)
    closed.close()
    examination = Examination(path, closed, lambda: None)
    examination.begin()
    assert examination.advance() and not examination.progress.running and examination.progress.message == BUSY
    path.unlink()
    with pytest.raises(BadInputFile, match="new-law"):
        examination.begin()


def test_a_custom_law_is_the_law_or_the_ghosts_law(tmp_path: Path) -> None:
    path = write(tmp_path / "my_law.py", STANDS_STILL)
    with session_of(path, scene="ball") as session:

        def moves() -> tuple[bool, bool]:
            session.advance(0.02)
            assert session.ghost is not None
            joints = session.simulation.avoiding.joints
            return bool(np.any(session.simulation.velocities[joints])), bool(
                np.any(session.ghost.velocities[joints])
            )

        session.change("ghost", "smooth_priority")
        assert (session.law_status.file, session.law_status.ghost_file) == ("my_law.py", None)
        until(lambda: moves() == (False, True))
        session.change("ghost", "own")
        assert (session.law_status.file, session.law_status.ghost_file) == (None, "my_law.py")
        assert session.simulation.steps == 0
        until(lambda: moves() == (True, False))
        assert session.law_status.problem == ""
        write(path, "def law(s):\n    return s.nominal / 0 + nothing")
        until(lambda: moves() and session.law_status.problem)
        assert "line 2: NameError" in session.law_status.problem and moves() == (True, False)
        write(path, PAPER)
        until(lambda: moves() == (True, True))
        assert session.law_status.problem == ""
        session.change("ghost", "off")
        assert (session.law_status.file, session.law_status.ghost_file) == ("my_law.py", None)


VERDICTS = tuple(TrialResult(name, name != NAMES[1], f"d < {i} mm & so on") for i, name in enumerate(NAMES))
PANELS = {
    "before": (ExaminationProgress("a<b>.py"), "", False, False),
    "in the middle, frozen": (
        ExaminationProgress("my_law.py", VERDICTS[:3], True),
        "line 2: <script>",
        False,
        False,
    ),
    "at the end": (ExaminationProgress("my_law.py", VERDICTS), "", False, False),
    "passed": (ExaminationProgress("my_law.py", VERDICTS), "", False, True),
    "of another text": (ExaminationProgress("my_law.py", VERDICTS, stale=True), "", False, False),
    "the file is gone": (ExaminationProgress("my_law.py"), "", True, False),
    "a message": (ExaminationProgress("my_law.py", message="<no"), "", False, False),
    "all failed": (
        ExaminationProgress("my_law.py", tuple(TrialResult(name, False, "|J_d| = 0") for name in NAMES)),
        "",
        False,
        False,
    ),
}


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_test_describes_its_result(language: Language, approve: Approve) -> None:
    set_language(language)
    pages = {state: law_html(*given) for state, given in PANELS.items()}
    assert "<script" not in "".join(pages.values()) and "<no" not in pages["a message"]
    assert 'role="status"' in pages["in the middle, frozen"] and "card wrong" in pages["at the end"]
    assert "<p>|J<sub>d</sub>| = 0" in pages["all failed"]
    approve(
        f"panel {language}.txt", "\n".join(f"# {state}\n{shown_text(html)}" for state, html in pages.items())
    )
