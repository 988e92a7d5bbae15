"""A cell's law as the text of a file, and a cell's steps, without a kernel."""

import math
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.features.custom_law.law_file import LawFile
from app.features.custom_law.student_law import take_law_file
from app.features.jupyter.cell_law import law_text
from app.features.jupyter.notebook_run import GivenVelocities, all_changed, key_of, step_with
from app.features.studies.background_studies import BackgroundStudies
from app.recording.run_file import saved_bytes, saved_from
from app.session.session import Session
from app.settings import Settings
from controllers.errors import BadInputFile, BadSetting
from scenes.rerun import rerun
from scenes.settings import changed
from tests.app.features.custom_law.helpers import PAPER, SITUATION, law_of, write
from tests.app.runtime.processes import until

GAIN, WEIGHTS, OTHER = 0.5, np.arange(7.0), object()


def helped(x: float) -> float:
    return GAIN * x


def own(situation: Any) -> Any:
    # `OTHER` is neither a number nor a module: a law that uses it fails when it is called.
    return math.sqrt(4.0) * helped(1.0) * situation.nominal + WEIGHTS * 0.0


def test_the_text_of_a_function_includes_what_it_uses() -> None:
    file = LawFile("law.py", law_text(own).encode(), 2**29)
    np.testing.assert_array_equal(file.velocities(SITUATION)[0], SITUATION.nominal)
    text = law_text(own).splitlines()
    (first,) = [number for number, line in enumerate(text) if line.startswith("def own(")]
    assert first == own.__code__.co_firstlineno - 1 and "OTHER" not in text[0]


ROOT, SINGLE, MOST = np.sqrt(4.0), np.float32(0.5), np.array([np.inf, -np.inf, np.nan])
LEAST = -math.inf


def numbers(situation: Any) -> Any:
    came = MOST[0] > 1e300 and MOST[1] == LEAST and math.isnan(MOST[2])
    return ROOT * SINGLE * situation.nominal if came else None


def test_the_text_of_a_function_includes_numpy_values() -> None:
    file = LawFile("law.py", law_text(numbers).encode(), 2**29)
    np.testing.assert_array_equal(file.velocities(SITUATION)[0], SITUATION.nominal)


@pytest.mark.parametrize("wrong", [lambda situation: situation.nominal, 3, print])
def test_lambdas_and_builtins_are_refused(wrong: Any) -> None:
    with pytest.raises(BadSetting, match="written with def"):
        law_text(wrong)


def test_settings_have_a_short_and_a_long_name() -> None:
    assert [key_of(name) for name in ("dm", "critical_distance", "n", "order", "scene")] == [
        "dm",
        "dm",
        "n",
        "n",
        "scene",
    ]
    law = all_changed(Settings(), {"critical_distance": 0.2, "n": 3}).run.law
    assert (law.critical_distance, law.order) == (0.2, 3.0)
    with pytest.raises(BadSetting, match="nothing"):
        all_changed(Settings(), {"nothing": 1})


def test_a_step_of_a_cell_is_part_of_the_run(tmp_path: Path) -> None:
    with closing(Session(Settings())) as session:
        given = GivenVelocities(np.full(7, 0.1))
        before = session.simulation.time
        for _ in range(5):
            assert step_with(session, given)
        assert session.paused and session.simulation.time == pytest.approx(before + 0.025)
        joints = session.simulation.avoiding.joints
        np.testing.assert_allclose(session.simulation.velocities[joints], 0.1)
        recorded = session.inputs.window()
        assert recorded is not None
        np.testing.assert_array_equal(rerun(recorded).table, session.simulation.history.table())
        assert saved_from(saved_bytes(recorded), "it").recorded.steps == 5
        # Then a file's law is taken; an unreadable file changes nothing.
        with pytest.raises(BadInputFile):
            take_law_file(session, tmp_path / "none.py")
        assert session.law.of_run is None
        session.change("ghost", "smooth_priority")
        take_law_file(session, write(tmp_path / "law.py", PAPER))
        assert session.law_status.file == "law.py" and session.simulation.steps == 0
        session.control.toggle_pause()
        until(lambda: session.advance(0.03) < 0 or session.simulation.steps > 20)
        assert (
            session.law_status.problem == ""
            and session.ghost is not None
            and session.parts.of(BackgroundStudies).trade_off is None
        )


def test_a_step_waits_for_the_law_of_the_ghost(tmp_path: Path) -> None:
    file = write(tmp_path / "law.py", PAPER)
    with closing(Session(changed(Settings(), "ghost", "own"), law=law_of(file))) as session:
        given = GivenVelocities(np.zeros(7))
        assert not step_with(session, given) and session.simulation.steps == 0, (
            "the law's process has not started"
        )
        until(lambda: (session.advance(0.03), step_with(session, given))[1])
        assert session.ghost is not None and session.simulation.steps == session.ghost.steps == 1
