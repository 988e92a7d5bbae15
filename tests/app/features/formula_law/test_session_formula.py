"""A formula in a session: it runs, is saved with the session, and ends when a law is chosen."""

from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from app.features.custom_law.trials import TRIALS
from app.features.formula_law.formula import BadFormula, Formula
from app.features.formula_law.formula_law import FILE, FormulaLaw
from app.features.formula_law.formula_tests import examine_formula
from app.features.formula_law.session_formula import FIRST, PAPER, SessionFormula
from app.features.studies.background_studies import BackgroundStudies
from app.session.session import Session
from app.settings import Settings
from scenes.inputs_file import recorded_bytes, recorded_from
from scenes.laws import DEFAULT_LAW
from scenes.settings import LawSettings, changed
from tests.app.features.custom_law.helpers import PAPER as FILE_OF_PAPER
from tests.app.features.custom_law.helpers import SITUATION, session_of, write
from tests.app.inline import Inline


def a_session(**settings: object) -> "closing[Session]":
    given = Settings()
    for key, value in settings.items():
        given = changed(given, key, value)
    return closing(Session(given))


def played(session: Session, steps: int = 40) -> np.ndarray:
    session.control.halt.set("visitor")
    for _ in range(steps):
        session.control.single_step()
        session.advance(0.01)
    return session.simulation.history.table()


def test_the_papers_law_as_a_formula_moves_the_arm_equally() -> None:
    with a_session(law=DEFAULT_LAW) as plain, a_session(law=DEFAULT_LAW) as session:
        formula = session.parts.of(SessionFormula)
        formula.run(PAPER)
        assert session.law_status.file == FILE and formula.runs
        np.testing.assert_allclose(played(session), played(plain), atol=1e-9)
        law = session.law.of_run
        assert law is not None
        for d in (-0.1, 0.0, 0.1, 0.2, float("inf")):
            paper = LawSettings(law=DEFAULT_LAW).made()
            assert law.activation(d) == pytest.approx(paper.activation(d))
            assert law.line_rate(d, 0.1, 0.0, 1.0) == pytest.approx(paper.line_rate(d, 0.1, 0.0, 1.0))


def test_a_formula_follows_the_sliders_it_names() -> None:
    with a_session() as session:
        session.parts.of(SessionFormula).run("where(d < d_m, v, 0)")
        law = session.law.of_run
        assert law is not None
        assert law.line_rate(0.2, 0.0, 0.0, 1.0) == 0.0
        session.change("dm", 0.25)
        session.change("v", 0.5)
        assert law.line_rate(0.2, 0.0, 0.0, 1.0) == 0.5


def test_a_failing_formula_freezes_its_arm_and_names_the_place() -> None:
    law = FormulaLaw(Formula("1 / (d - d)"), LawSettings)
    assert not law(SITUATION).any()
    # Python's name for the error differs by version; the place is our own text.
    assert law.problem is not None and " at d = 0.1 m, u = " in str(law.problem.text)
    with a_session() as session:
        session.parts.of(SessionFormula).run("10^10^10")
        played(session, 2)
        assert "too large" in session.law_status.problem
        session.parts.of(SessionFormula).run("0")
        played(session, 2)
        assert session.law_status.problem == ""


def test_a_refused_formula_changes_nothing() -> None:
    with a_session() as session:
        formula = session.parts.of(SessionFormula)
        formula.run("u")
        law = session.law.of_run
        with pytest.raises(BadFormula):
            formula.run("u.__class__")
        assert session.law.of_run is law and formula.text == "u"


def test_a_session_keeps_its_formula() -> None:
    with a_session() as before, a_session() as after:
        before.parts.of(SessionFormula).run("v + u")
        after.parts.restore(before.parts.saved())
        formula = after.parts.of(SessionFormula)
        assert formula.text == "v + u" and formula.runs and after.simulation.law is after.law.of_run
        formula.stop()
        assert not formula.runs and after.law_status.file is None
        with a_session() as third:
            third.parts.restore(after.parts.saved())
            assert third.parts.of(SessionFormula).text == "v + u" and not third.parts.of(SessionFormula).runs


@pytest.mark.parametrize(
    "saved",
    [b"", b"\xff", b"[]", b"{}", b'{"text": "d.real", "runs": true}', b'{"text": 1e999, "runs": true}'],
)
def test_a_broken_record_restores_nothing(saved: bytes) -> None:
    with a_session() as session:
        session.parts.restore({SessionFormula.name: saved})
        formula = session.parts.of(SessionFormula)
        assert formula.text == "" and not formula.runs


def test_choosing_a_law_ends_the_formula_and_keeps_its_text() -> None:
    with a_session(law="unprotected") as session:
        formula = session.parts.of(SessionFormula)
        formula.run("u")
        session.change("v", 0.4)
        assert formula.runs
        session.change("law", "strict_priority")
        assert not formula.runs and formula.text == "u" and not session.law.given
        session.change("ghost", "own")
        formula.run("v")
        session.change("law", "unprotected")
        assert formula.runs and session.law_status.ghost_file == FILE and session.law_status.file is None


def test_the_law_of_a_file_has_priority_over_a_formula(tmp_path: Path) -> None:
    with session_of(write(tmp_path / "my_law.py", FILE_OF_PAPER)) as session:
        session.parts.restore({SessionFormula.name: b'{"text": "v", "runs": true}'})
        formula = session.parts.of(SessionFormula)
        assert not formula.possible and not formula.runs and session.law_status.file == "my_law.py"
        formula.stop()
        assert session.law_status.file == "my_law.py"


def test_a_run_with_a_formula_is_saved() -> None:
    with a_session() as session:
        session.parts.of(SessionFormula).run(PAPER)
        played(session, 20)
        recorded = session.inputs.window()
        assert recorded is not None and recorded.law is not None
        kept = recorded_from(recorded_bytes(recorded), "run.npz").law
        assert kept is not None and (kept.file, kept.sha256) == (FILE, recorded.law.sha256)


@pytest.mark.slow
def test_the_papers_formula_passes_all_six_tests() -> None:
    assert [examine_formula(PAPER, name).passed for name in TRIALS] == [True] * len(TRIALS)


@pytest.mark.slow
def test_the_first_formula_of_the_editor_is_not_smooth() -> None:
    assert [name for name in TRIALS if not examine_formula(FIRST, name).passed] == ["smooth"]


@pytest.mark.slow
def test_a_formula_fails_a_test_with_its_reason() -> None:
    verdict = examine_formula("v / d", "bounded where J_d is singular")
    assert not verdict.passed and "division by zero" in verdict.reason
    assert not examine_formula("0", "gets out").passed
    assert examine_formula("0", "quick").passed


def test_studies_pause_while_a_formula_runs_and_resume_after_it() -> None:
    with closing(Session(Settings(), background=Inline())) as session:
        formula, studies = session.parts.of(SessionFormula), session.parts.of(BackgroundStudies)
        assert studies.trade_off is not None
        formula.run(PAPER)
        assert studies.trade_off is None
        formula.stop()
        assert studies.trade_off is not None
