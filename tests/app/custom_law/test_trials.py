"""The six tests of a student's law: what a sensible law passes, what each of the others fails, and what is said of it."""

import math
import textwrap
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

from app.cli.laws import LawTest, NewLaw, law_test, new_law
from app.custom_law import template
from app.custom_law.examine import Dropped, examine, examine_one
from app.custom_law.law_file import LawFile
from app.custom_law.law_limits import LawProblem
from app.custom_law.trial_result import TrialResult
from app.custom_law.trials import TRIALS, examine_law
from controllers.errors import BadInputFile, BadSetting
from controllers.kinematics import Array
from controllers.laws.situation import Law, Situation
from scenes.law_factory import make_law
from scenes.settings import LawName, LawSettings
from tests.app.custom_law.helpers import PAPER, received, situation, write

KEEPS, ALONE, OUT, SMOOTH, BOUNDED, QUICK = TRIALS


class Candidate:
    """A law of this process; what the tests do not ask is the built-in one's."""

    wants_all_pairs: ClassVar[bool] = True
    wants_task: ClassVar[bool] = True
    problem: LawProblem | None = None
    seconds = 1e-5

    def __init__(self, built_in: Law, own: Callable[[Situation], Array] | None = None) -> None:
        self.activation, self.line_rate, self._law = built_in.activation, built_in.line_rate, own or built_in

    def __call__(self, situation: Situation) -> Array:
        return self._law(situation)


def built_in(name: LawName = "smooth_priority", **settings: Any) -> Candidate:
    return Candidate(make_law(LawSettings(law=name, **settings)))


def from_text(text: str) -> Candidate:
    file = LawFile("my_law.py", textwrap.dedent(text).encode(), 2**28)
    return Candidate(make_law(LawSettings()), lambda situation: file.velocities(received(situation))[0])


@cache
def verdicts_of(name: LawName) -> dict[str, TrialResult]:
    """Of a built-in law; to be read only."""
    return {verdict.name: verdict for verdict in examine_law(built_in(name))}


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


def test_a_law_of_a_student_fails_what_it_should() -> None:
    verdicts, unprotected = examine_law(from_text(SWITCHED)), verdicts_of("unprotected")
    assert failed(verdicts) == {SMOOTH}, verdicts
    for verdict in (*verdicts, *unprotected.values()):
        assert verdict.passed == ("fails" not in verdict.reason) and ("≤" in verdict.reason or "≥" in verdict.reason)
        assert all(math.isfinite(number) for number in verdict.numbers.values()) and len(verdict.numbers) >= 2
    assert "a jump stays, however small dt" in next(v.reason for v in verdicts if v.name == SMOOTH)
    assert "fails by 184." in unprotected[KEEPS].reason and "fails by 201." in unprotected[OUT].reason


def test_through_another_process(tmp_path: Path) -> None:
    # And the tests are made on the text that is given, whatever the file says by then.
    path = write(tmp_path / "my_law.py", "def law(s):\n    return s.nominal * 0")
    (verdict,) = examine(path, only=(OUT,), text=TASK_ONLY.encode())
    assert verdict == verdicts_of("unprotected")[OUT]
    asked = 0

    def stopped() -> bool:
        nonlocal asked
        asked += 1
        return asked > 30

    path = write(tmp_path / "my_law.py", TASK_ONLY)
    with pytest.raises(Dropped):
        examine_one(path, path.read_bytes(), KEEPS, stopped)
    assert asked == 31


def test_a_new_law_is_the_papers_and_fails_what_the_paper_left_open(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "her_law.py"
    assert new_law(NewLaw(path)) == 0
    assert "lwr-duet law-test" in capsys.readouterr().out
    text = path.read_text(encoding="utf-8")
    assert "law-test her_law.py" in text and "my_law.py" not in text
    # The other three are made on the same law in this process, see below; through another one they take their time.
    monkeypatch.setattr("app.custom_law.trials.TRIALS", {name: TRIALS[name] for name in (OUT, BOUNDED, QUICK)})
    assert law_test(LawTest(path)) == 1
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 4 and lines[-1] == "her_law.py: 2 of 3 tests passed."
    assert [line[:4] for line in lines[:-1]] == ["pass", "FAIL", "pass"]
    assert BOUNDED in lines[1] and "fails by" in lines[1]


FAILED: dict[LawName, set[str]] = {
    "smooth_priority": set(),
    "strict_priority": {ALONE, SMOOTH},
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


@pytest.mark.parametrize(("name", "failures"), FAILED.items())
def test_what_the_built_in_laws_fail(name: LawName, failures: set[str]) -> None:
    assert failed(list(verdicts_of(name).values())) == failures


def test_numbers_of_the_built_in_laws() -> None:
    # The barrier keeps d_m as soon as it knows how fast the hand comes; the paper's law with n = 1 harms the task from afar.
    (kept,) = examine_law(built_in("barrier_qp", feed_forward=True), only=(KEEPS,))
    assert kept.passed and not verdicts_of("barrier_qp")[KEEPS].passed
    early, out, bounded = examine_law(built_in(order=1.0), only=(ALONE, OUT, BOUNDED))
    assert not early.passed and "the hand leaves its place by 7" in early.reason
    assert out.passed and bounded.passed
    # Far from the ball the hand rests where λ (v + u) = u; out of the overlap it takes (d_m − d) / v; of a jump all is left.
    paper = verdicts_of("smooth_priority")
    numbers = paper[ALONE].numbers
    # K |e| ≈ u, up to the angle between the row and the hand's way, and to the part of 1.5 s that is too short to settle.
    lam = (0.15 / numbers["d"]) ** 6
    assert numbers["beside_a_ball"] == pytest.approx(lam * 0.3 / 2.0, rel=0.2)
    numbers = paper[OUT].numbers
    assert numbers["time"] == pytest.approx((0.15 - numbers["d_start"]) / 0.3, abs=0.03)
    assert paper[SMOOTH].numbers["share"] == pytest.approx(0.5, abs=0.02)
    assert verdicts_of("strict_switched")[SMOOTH].numbers["share"] == pytest.approx(1.0, abs=0.02)
    # Digit for digit where J_d is regular, with the same λ.
    paper, there = make_law(LawSettings()), situation()
    assert [template.activation(d) for d in (0.1, 0.2, math.inf)] == [paper.activation(d) for d in (0.1, 0.2, math.inf)]
    np.testing.assert_allclose(template.law(there), paper(there), rtol=1e-3)


def test_laws_that_fail_and_files_that_cannot_be_loaded(tmp_path: Path) -> None:
    # An exception in overlap ends the three tests that come there, with its line; the others start again.
    text = PAPER + "    def guard(d):\n        if d < 0:\n            raise ValueError('overlap')\n"
    text = text.replace("        c = ", "        guard(situation.distance)\n        c = ")
    verdicts = examine(write(tmp_path / "my_law.py", text), only=(OUT, ALONE, BOUNDED, QUICK))
    assert [verdict.passed for verdict in verdicts] == [False, True, False, False]
    for verdict in verdicts:
        if not verdict.passed:
            assert verdict.reason.startswith("my_law.py, line 13: ValueError: overlap") and verdict.numbers == {}
    verdicts = examine(write(tmp_path / "my_law.py", "def law(s)\n"))
    assert failed(verdicts) == set(TRIALS)
    assert {verdict.reason for verdict in verdicts} == {"my_law.py, line 1: SyntaxError: expected ':', in “def law(s)”"}
    with pytest.raises(BadInputFile, match="no such file"):
        examine(tmp_path / "other.py")


def test_a_slow_law_is_named_and_does_not_hold_the_others_up() -> None:
    """2 ms a call: too slow. 60 ms a call: the runs are ended after 10 s of calls."""
    law = built_in()
    law.seconds = 0.002
    verdicts = examine_law(law, only=(OUT, QUICK))
    assert [verdict.passed for verdict in verdicts] == [True, False]
    assert "a call ≤ 1 ms fails: the median of 300 calls is 2 ms" in verdicts[-1].reason
    law.seconds = 0.06
    verdicts = examine_law(law)
    assert failed(verdicts) == {KEEPS, SMOOTH, OUT, ALONE, QUICK}
    assert "a call takes 60 ms" in verdicts[0].reason


def test_nothing_is_overwritten(tmp_path: Path) -> None:
    path = write(tmp_path / "my_law.py", "mine")
    for there, says in ((path, "is there already"), (tmp_path, "is there already"), (tmp_path / "no" / "my_law.py", "cannot be")):
        with pytest.raises(BadSetting, match=says):
            new_law(NewLaw(there))
    assert path.read_text(encoding="utf-8") == "mine"
