"""A student's law in its own process is a law like any other, and a failure freezes the arm and nothing else."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from app.custom_law.custom_law import CustomLaw
from controllers.kinematics import Array
from controllers.laws.situation import Law
from scenes.history import COLUMN
from scenes.settings import LawSettings, RunSettings
from scenes.simulation import Simulation
from tests.app.custom_law.helpers import GOOD, PAPER, SITUATION, situation, write


@pytest.fixture(scope="module")
def paper(tmp_path_factory: pytest.TempPathFactory) -> Iterator[CustomLaw]:
    """The paper's law from a file, in one process for all tests that only call it; without damping, as it is printed."""
    path = write(tmp_path_factory.mktemp("paper") / "my_law.py", PAPER.replace("0.30, 0.06", "0.30, 0.0"))
    with CustomLaw(path, waits=True) as law:
        yield law
        assert law.problem is None


def test_it_is_a_law_like_any_other(paper: CustomLaw) -> None:
    """q̇, λ and the line's speed are the file's; the same situation gives the same bits; the situation itself is not touched."""
    law: Law = paper
    assert isinstance(law, CustomLaw)
    before = [np.copy(value) for value in SITUATION if isinstance(value, np.ndarray)]
    first, again = law(SITUATION), law(SITUATION)
    assert_array_equal(first, again)
    J_d = SITUATION.row
    np.testing.assert_allclose(first, SITUATION.nominal + J_d * (0.3 + SITUATION.pull) / (J_d @ J_d), rtol=1e-14)
    first[:] = 0.0  # It is the caller's.
    for value, now in zip(before, (v for v in SITUATION if isinstance(v, np.ndarray)), strict=True):
        assert_array_equal(now, value)
    assert law.activation(0.3) == law.activation(0.3) == 0.5**6
    assert law.line_rate(0.1, 0.2, 0.0, 1.0) == pytest.approx(0.3)
    assert_array_equal(law.line_rates(np.array([0.1, 0.3]), 0.2, 0.0, 1.0), [law.line_rate(d, 0.2, 0.0, 1.0) for d in (0.1, 0.3)])
    assert law(situation(14)).shape == (14,) and law(SITUATION._replace(rows=None, distances=None)).shape == (7,)
    assert law.wants_task and law.wants_all_pairs
    assert law.ready and law.problem is None and law.seconds < 1.0


def test_a_file_with_its_neighbours(file: Path) -> None:
    # Without an activation it is nought and pairs may be left out.
    with CustomLaw(write(file, "WANTS_ALL_PAIRS = False\n" + GOOD), waits=True) as law:
        assert law.activation(0.1) == 0.0
        assert law.load()
        assert not law.wants_all_pairs and CustomLaw.wants_all_pairs
    # A module and a table beside it; the arrays are its own.
    write(file.with_name("gains.py"), "GAIN = 3.0")
    np.save(file.with_name("table.npy"), np.arange(7.0))
    text = """
        import numpy as np
        from gains import GAIN
        TABLE = np.load("table.npy")

        def law(s):
            s.nominal[:] = GAIN
            s.nominal.sort()
            return s.nominal + TABLE
    """
    with CustomLaw(write(file, text), waits=True) as law:
        assert_array_equal(law(SITUATION), 3.0 + np.arange(7.0))
        assert law.problem is None


def test_what_it_prints_and_asks_for_goes_nowhere(file: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Megabytes of it, from Python and from below, block nothing; `input` is not answered."""
    text = """
        import os, sys
        print("x" * 1_000_000)

        def law(s):
            print("q", s.positions)
            sys.stderr.write("y" * 100_000)
            os.write(1, b"z" * 100_000)
            os.write(2, b"z" * 100_000)
            try:
                input("Well?")
            except EOFError:
                return s.nominal
    """
    with CustomLaw(write(file, text), waits=True) as law:
        for _ in range(3):
            assert_array_equal(law(SITUATION), SITUATION.nominal)
    assert capfd.readouterr() == ("", "")


def test_it_moves_an_arm(paper: CustomLaw) -> None:
    """The paper's law from a file makes the run that the paper's law makes, as the law and as a second simulation's beside it."""
    settings = RunSettings(scene="ball", law=LawSettings(law="smooth_priority"))
    reference, own, other = Simulation(settings), Simulation(settings), Simulation(settings)
    own.law = other.law = paper
    for _ in range(300):
        for simulation in (reference, own, other):
            simulation.step(None)
    assert paper.problem is None
    columns = [COLUMN[name] for name in ("d", "lambda", "e2")]
    for simulation in (own, other):
        np.testing.assert_allclose(simulation.history.table()[:, columns], reference.history.table()[:, columns], atol=1e-12)


def test_a_failure_freezes_the_arm_and_nothing_else(file: Path) -> None:
    """In the middle of a run: the arm stands still from the next step on, the other one goes on."""
    text = """
        calls = 0

        def law(s):
            global calls
            calls += 1
            return s.nominal if calls < 50 else s.nominal[calls]
    """
    simulation = Simulation(RunSettings())
    person = simulation.source()
    with CustomLaw(write(file, text), waits=True) as law:
        simulation.law = law
        moved: list[tuple[Array, Array]] = []
        for _ in range(200):
            simulation.step(person.target(simulation.time))
            velocities = simulation.velocities
            moved.append((velocities[simulation.avoiding.joints].copy(), velocities[simulation.guided.joints].copy()))
        assert law.problem is not None and law.problem.line == 6 and "IndexError" in law.problem.text
    assert all(not np.any(avoiding) for avoiding, _ in moved[49:])
    assert all(np.any(guided) for _, guided in moved[100:])
