"""A working custom law in its own process: like any law, isolated when it fails, reloaded on save."""

import os
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from app.features.custom_law import custom_law as custom_law_module
from app.features.custom_law.custom_law import CustomLaw
from app.features.custom_law.law_limits import LawLimits
from controllers.laws.situation import Law
from tests.app.features.custom_law.helpers import GOOD, PAPER, SHORT, SITUATION, situation, soon, write
from tests.app.runtime.processes import gone, until

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def paper(tmp_path_factory: pytest.TempPathFactory) -> Iterator[CustomLaw]:
    """The paper's law from a file, undamped as printed; one process for all tests that only call it."""
    path = write(tmp_path_factory.mktemp("paper") / "my_law.py", PAPER.replace("0.30, 0.06", "0.30, 0.0"))
    with CustomLaw(path, waits=True) as law:
        yield law
        assert law.problem is None


def test_a_custom_law_behaves_as_any_law(paper: CustomLaw) -> None:
    law: Law = paper
    assert isinstance(law, CustomLaw)
    before = [np.copy(value) for value in SITUATION if isinstance(value, np.ndarray)]
    first, again = law(SITUATION), law(SITUATION)
    assert_array_equal(first, again)
    J_d = SITUATION.row
    np.testing.assert_allclose(
        first, SITUATION.nominal + J_d * (0.3 + SITUATION.pull) / (J_d @ J_d), rtol=1e-14
    )
    first[:] = 0.0  # The array belongs to the caller.
    for value, now in zip(before, (v for v in SITUATION if isinstance(v, np.ndarray)), strict=True):
        assert_array_equal(now, value)
    assert law.activation(0.3) == law.activation(0.3) == 0.5**6
    assert law.line_rate(0.1, 0.2, 0.0, 1.0) == pytest.approx(0.3)
    assert_array_equal(
        law.line_rates(np.array([0.1, 0.3]), 0.2, 0.0, 1.0),
        [law.line_rate(d, 0.2, 0.0, 1.0) for d in (0.1, 0.3)],
    )
    assert law(situation(14)).shape == (14,) and law(SITUATION._replace(rows=None, distances=None)).shape == (
        7,
    )
    assert law.wants_task and law.wants_all_pairs
    assert law.ready and law.problem is None and law.seconds < 1.0


def test_a_file_imports_its_neighbours(file: Path) -> None:
    # Without an activation λ is 0, and pairs may be omitted.
    with CustomLaw(write(file, "WANTS_ALL_PAIRS = False\n" + GOOD), waits=True) as law:
        assert law.activation(0.1) == 0.0
        assert law.load()
        assert not law.wants_all_pairs and CustomLaw.wants_all_pairs
    # The module and the table are in the same folder; the arrays belong to the law.
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


def test_output_of_a_law_is_discarded_and_its_input_is_empty(
    file: Path, capfd: pytest.CaptureFixture[str]
) -> None:
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


@pytest.fixture
def eager(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(custom_law_module, "LOOK", 0.0)


PLENTY = LawLimits(load=1.0, call=0.5, memory=SHORT.memory)
"""Short for an endless loop, enough for a good law that gets no core for a while."""

ENDLESS = "def law(s):\n    while True: pass"
LARGE = "#" * 900_000 + "\n"  # larger than the buffer of a socket


@pytest.mark.usefixtures("eager")
def test_a_law_is_reloaded_on_save(file: Path) -> None:
    with CustomLaw(write(file, GOOD), PLENTY) as law:
        pids: set[int | None] = set()

        def moves(factor: float, says: str) -> bool:
            law.refresh()
            pids.add(law.pid)
            works = law.problem is None if not says else law.problem is not None and says in law.problem.text
            return bool(np.array_equal(soon(law), SITUATION.nominal * factor)) and works

        saves = (
            (GOOD, 2, ""),
            (GOOD.replace("2", "3.5"), 3.5, ""),
            ("def law(s)\n", 0, "SyntaxError"),
            (LARGE + GOOD, 2, ""),
        )
        for number, (text, factor, says) in enumerate(saves):
            # Some editors write into the file, others replace it.
            if number % 2:
                os.replace(write(file.with_suffix(".tmp"), text), file)
            else:
                write(file, text)
            until(partial(moves, factor, says))
        assert len(pids - {None}) == 4
        assert [pid for pid in pids if pid is not None and not gone(pid)] == [law.pid]


@pytest.mark.usefixtures("eager")
def test_a_file_without_new_text_does_not_restart_the_process(file: Path) -> None:
    # The process survives a save of the same text and a file that is briefly missing, as with some editors.
    with CustomLaw(write(file, GOOD), waits=True) as law:
        law(SITUATION)
        pid = law.pid
        assert not law.refresh()
        os.utime(file, ns=(1, 1))
        assert not law.refresh()
        file.unlink()
        assert not law.refresh() and not law.away
        assert_array_equal(law(SITUATION), SITUATION.nominal * 2)
        while not law.away:
            assert not law.refresh()
        assert_array_equal(law(SITUATION), SITUATION.nominal * 2)
        write(file, GOOD)
        assert not law.refresh() and law.pid == pid and not law.away
        file.unlink()
        file.mkdir()
        assert law.refresh() and law.problem is not None and "cannot be read" in law.problem.text
        file.rmdir()
        write(file, GOOD)
        assert law.refresh()
        assert_array_equal(law(SITUATION), SITUATION.nominal * 2)
    # An unused law starts no process; its first use takes the latest saved text.
    with CustomLaw(write(file, "def law(s)")) as law:
        write(file, GOOD)
        assert law.refresh() and law.pid is None and not law.ready and law.problem is None
        until(lambda: np.any(soon(law)))


def test_the_file_is_checked_at_intervals(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    looks: list[float] = []
    now = 100.0
    monkeypatch.setattr(custom_law_module, "monotonic", lambda: now)
    with CustomLaw(write(file, GOOD)) as law:
        monkeypatch.setattr(custom_law_module, "_stamp", lambda path: looks.append(now))
        for i in range(100):
            now = 100.0 + 0.02 * i
            law.refresh()
    assert len(looks) == 3 and min(np.diff(looks)) >= 0.5


@pytest.mark.usefixtures("eager")
def test_broken_and_repaired_files_are_noticed_while_nothing_moves(file: Path) -> None:
    with CustomLaw(write(file, GOOD), PLENTY) as law:
        until(lambda: np.any(soon(law)))

        def is_said(says: str) -> bool:
            return not law.refresh() and (says in law.problem.text if law.problem else law.ready and not says)

        fails = "# It can be read now.\ndef law(s):\n    return s.nominal / 0 + undefined"
        for text, says in (
            ("def law(s)", "line 1"),
            (fails, "line 3"),
            (GOOD, ""),
            (ENDLESS, "endless loop"),
        ):
            write(file, text)
            until(partial(is_said, says))
