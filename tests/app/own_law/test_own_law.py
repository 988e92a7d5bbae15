"""A student's law in its own process: whatever it does, the arm freezes at worst, the line is named, and nothing is left behind."""

from __future__ import annotations

import gc
import os
import signal
import statistics
import subprocess
import sys
import textwrap
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from time import perf_counter

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from app.own_law import own_law as own_law_module
from app.own_law.limits import Limits
from app.own_law.own_law import OwnLaw
from controllers.errors import BadInputFile
from controllers.kinematics import Array
from controllers.laws.situation import Law
from scenes.history import COLUMN
from scenes.settings import LawSettings, RunSettings
from scenes.simulation import Simulation
from tests.app.own_law.helpers import PAPER, SHORT, gone, situation, until, write

ZEROS = np.zeros(7)
SITUATION = situation()
GOOD = "def law(s):\n    return s.nominal * 2"


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """Where the law is."""
    return tmp_path / "my_law.py"


@pytest.fixture
def eager(monkeypatch: pytest.MonkeyPatch) -> None:
    """The file is looked at whenever `refresh` is called."""
    monkeypatch.setattr(own_law_module, "LOOK", 0.0)


@pytest.fixture(scope="module")
def paper(tmp_path_factory: pytest.TempPathFactory) -> Iterator[OwnLaw]:
    """The paper's law from a file, in one process for all tests that only call it; without damping, as it is printed."""
    path = write(
        tmp_path_factory.mktemp("paper") / "my_law.py", PAPER.replace("MU = 0.15, 6.0, 0.30, 0.06", "MU = 0.15, 6.0, 0.30, 0.0")
    )
    with OwnLaw(path, waits=True) as law:
        yield law
        assert law.problem is None


def frozen(law: OwnLaw) -> str:
    """Call a law that fails; return what is said. Its process is gone at once, and nothing starts another."""
    with law:
        assert law.load() or law.problem
        pid = law.pid
        assert_array_equal(law(SITUATION), ZEROS)
        assert law.problem is not None and law.pid is None and not law.ready
        assert pid is None or gone(pid)
        assert_array_equal(law(SITUATION), ZEROS)
        assert law.activation(0.1) == 0.0 and np.isnan(law.line_rate(0.1, 0.1, 0.0, 1.0))
        assert law.pid is None
        assert law.problem.line is None or f"my_law.py, line {law.problem.line}: " in law.problem.text
        return law.problem.text


# ---- it works -----------------------------------------------------------------------------------------------------------------


def test_it_is_a_law_like_any_other(paper: OwnLaw) -> None:
    """q̇, λ and the line's speed are the file's; the same situation gives the same bits; the situation itself is not touched."""
    law: Law = paper
    assert isinstance(law, OwnLaw)
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


def test_without_an_activation_it_is_nought_and_pairs_may_be_left_out(file: Path) -> None:
    with OwnLaw(write(file, "WANTS_ALL_PAIRS = False\n" + GOOD), waits=True) as law:
        assert law.activation(0.1) == 0.0
        assert law.load()
        assert not law.wants_all_pairs and OwnLaw.wants_all_pairs


def test_it_may_change_what_it_is_given_and_use_its_neighbours(file: Path) -> None:
    """A module and a table beside it; the arrays are its own."""
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
    with OwnLaw(write(file, text), waits=True) as law:
        assert_array_equal(law(SITUATION), 3.0 + np.arange(7.0))
        assert law.problem is None


def test_what_it_prints_and_asks_for_goes_nowhere(file: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Megabytes of it, from Python and from below, block nothing; there is nobody to answer `input`."""
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
    with OwnLaw(write(file, text), waits=True) as law:
        for _ in range(3):
            assert_array_equal(law(SITUATION), SITUATION.nominal)
    assert capfd.readouterr() == ("", "")


def test_it_moves_an_arm(paper: OwnLaw) -> None:
    """The paper's law from a file makes the run that the paper's law makes, as the law and as a second simulation's beside it."""
    settings = RunSettings(scene="ball", law=LawSettings(law="smooth_priority"))
    reference, own, other = Simulation(settings), Simulation(settings), Simulation(settings)
    own.law = other.law = paper
    for _ in range(300):
        for simulation in (reference, own, other):
            simulation.step(None)
    assert paper.problem is None
    for name in ("d", "lambda", "e2"):
        column = COLUMN[name]
        np.testing.assert_allclose(own.history.table()[:, column], reference.history.table()[:, column], atol=1e-12)
        np.testing.assert_allclose(other.history.table()[:, column], reference.history.table()[:, column], atol=1e-12)


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
    person = simulation.person()
    with OwnLaw(write(file, text), waits=True) as law:
        simulation.law = law
        moved: list[tuple[Array, Array]] = []
        for _ in range(200):
            simulation.step(person.target(simulation.time))
            velocities = simulation.velocities
            moved.append((velocities[simulation.avoiding.joints].copy(), velocities[simulation.guided.joints].copy()))
        assert law.problem is not None and law.problem.line == 6 and "IndexError" in law.problem.text
    assert all(not np.any(avoiding) for avoiding, _ in moved[49:])
    assert all(np.any(guided) for _, guided in moved[100:])


# ---- it fails -----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("def law(s):\n    return s.nominal / s.gain", "line 2: AttributeError: 'Situation' object has no attribute 'gain'"),
        ("def law(s:\n    return None", "line 1: SyntaxError: '(' was never closed"),
        ("import os\ndef law(s):\n    os._exit(3)", "my_law.py: it ended its own process (exit code 3); a law returns velocities"),
        ("import os\ndef law(s):\n    os.abort()", "line 3: its process crashed (SIGABRT), in “os.abort()”"),
        ("import ctypes\ndef law(s):\n    ctypes.string_at(0)", "line 3: its process crashed (SIGSEGV), in “ctypes.string_at(0)”"),
        ("import socket\ndef law(s):\n    for i in range(3, 20):\n        try:\n            socket.socket(fileno=i).send(bytes(99))\n"
         "        except OSError:\n            pass", "it wrote to the line between its process and the page"),
    ],
)  # fmt: skip
def test_how_it_may_fail(file: Path, text: str, says: str) -> None:
    """While it is called, while it is loaded, and by what no exception tells of; `test_law_file` has all the rest."""
    said = frozen(OwnLaw(write(file, text), waits=True))
    assert says in said, said


@pytest.mark.parametrize(
    ("text", "line", "waits"),
    [
        ("def law(s):\n    while True:\n        pass", (2, 3), True),
        ("def law(s):\n    while True:\n        pass", (2, 3), False),
        ("def law(s):\n    import time\n    time.sleep(100)", (3,), True),
        ("def law(s):\n    return sum(range(10**12))", (2,), True),
        ("x = 1\nwhile True:\n    x += 1\ndef law(s):\n    return s.nominal", (2, 3), False),
        ("def law(s):\n    return s.nominal\ndef activation(d):\n    while True: d += 1", (4,), True),
    ],
    ids=["python", "python, nobody waits", "asleep", "below", "while it is read", "activation"],
)
def test_an_endless_loop_is_ended_and_named(file: Path, text: str, line: tuple[int, ...], waits: bool) -> None:
    """In Python, in C, asleep, while the file is read and in λ. Nobody is held up longer than the limits."""
    with OwnLaw(write(file, text), SHORT, waits) as law:
        pids: set[int | None] = set()

        def given_up() -> bool:
            law.activation(0.1)
            assert not np.any(law(SITUATION)) or "activation" in text
            pids.add(law.pid)
            return law.problem is not None

        until(given_up)
        assert law.problem is not None
        assert law.problem.line in line
        assert " ms, in “" in law.problem.text and "Is there an endless loop?" in law.problem.text
        assert ("reading the file did not end within 100 ms" in law.problem.text) == text.startswith("x = 1")
        assert all(pid is None or gone(pid) for pid in pids)


@pytest.mark.skipif(sys.platform != "linux", reason="only there is a process's memory counted")
@pytest.mark.parametrize(
    "hog",
    ["np.zeros(10**10)", "[bytearray(10**6) for _ in range(10**6)]", "kept.append(bytearray(30 * 10**6)) or s.nominal"],
    ids=["at once", "piece by piece", "call by call"],
)
def test_a_memory_hog_is_ended_and_named(file: Path, hog: str) -> None:
    text = f"import numpy as np\nkept = []\n\ndef law(s):\n    return {hog}"
    with OwnLaw(write(file, text), replace(SHORT, call=5.0), waits=True) as law:
        assert law.load()
        pid = law.pid
        for _ in range(10):
            law(SITUATION)
        assert law.problem is not None and pid is not None and gone(pid)
        assert law.problem.line == 5
        assert "more memory than the 96 MiB that a law may take" in law.problem.text


def test_its_descriptors_are_low_however_many_the_page_has_open(file: Path) -> None:
    """What the law may break in its process does not depend on the page's."""
    text = "import os\ndef law(s):\n    os.closerange(3, 20)"
    opened = [os.open(os.devnull, os.O_RDONLY) for _ in range(100)]
    try:
        assert "it hung up the line" in frozen(OwnLaw(write(file, text), waits=True))
    finally:
        for number in opened:
            os.close(number)


def test_ended_from_outside(file: Path) -> None:
    """Somebody kills the process while it waits, and while it works."""
    with OwnLaw(write(file, GOOD), waits=True) as law:
        law(SITUATION)
        assert law.pid is not None
        os.kill(law.pid, signal.SIGKILL)
        assert_array_equal(law(SITUATION), ZEROS)
        assert law.problem is not None and "ended from outside" in law.problem.text
        law.restart()
        assert_array_equal(law(SITUATION), SITUATION.nominal * 2)
        assert law.problem is None


def test_a_file_that_is_none(tmp_path: Path) -> None:
    for path, says in (
        (tmp_path / "no.py", "there is no such file; `lwr-duet new-law no.py` writes one"),
        (tmp_path, "cannot be read"),
        (write(tmp_path / "large.py", "#" * (2**20 + 1)), "larger than 1 MiB"),
    ):
        with pytest.raises(BadInputFile, match=says):
            OwnLaw(path)


def test_a_python_that_cannot_be_started(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A broken installation is a message too, with or without a process."""
    for executable, says in ((str(file.parent / "python"), "No such file"), ("/bin/false", "exit code 1")):
        monkeypatch.setattr(sys, "executable", executable)
        with OwnLaw(write(file, GOOD), waits=True) as law:
            assert_array_equal(law(SITUATION), ZEROS)
            assert law.problem is not None and "could not be started" in law.problem.text and says in law.problem.text


# ---- it does not hold anybody up ----------------------------------------------------------------------------------------------


def test_a_slow_beginning_holds_nobody_up(file: Path, tmp_path: Path) -> None:
    """While the file is read, and while the first call loads something, the arm stands still and calls return; then it moves."""
    text = f"""
        import pathlib, time

        def wait(name):
            while not pathlib.Path({str(tmp_path)!r}, name).exists():
                time.sleep(0.001)

        wait("read")

        def law(s):
            wait("call")
            return s.nominal * 2
    """
    with OwnLaw(write(file, text), Limits(load=30.0, call=0.01)) as law:
        for _ in range(100):
            assert_array_equal(law(SITUATION), ZEROS)
        assert law.problem is None and not law.ready
        (tmp_path / "read").touch()
        until(lambda: law.ready)
        for _ in range(100):
            assert_array_equal(law(SITUATION), ZEROS)
        assert law.problem is None
        (tmp_path / "call").touch()
        until(lambda: np.any(law(SITUATION)))
        assert_array_equal(law(SITUATION), SITUATION.nominal * 2)
        assert law.problem is None


def test_a_curve_takes_no_longer_than_it_may(file: Path) -> None:
    """A law of 5 ms a call leaves the rest of its curve blank instead of holding up the page."""
    text = "import time\ndef law(s):\n    time.sleep(0.005)\n    return s.nominal"
    with OwnLaw(write(file, text), Limits(call=1.0), waits=True) as law:
        found = law.line_rates(np.linspace(0.0, 0.6, 100), 0.1, 0.0, 1.0)
        assert found[0] == pytest.approx(-0.1) and np.isnan(found[-1])
        assert law.problem is None


def test_how_long_a_call_takes(paper: OwnLaw, record_property: Callable[[str, object], None]) -> None:
    """Measured, not asserted: the median of 500 calls there and back."""
    taken: list[float] = []
    for _ in range(500):
        begin = perf_counter()
        paper(SITUATION)
        taken.append(perf_counter() - begin)
    assert paper.problem is None
    record_property("call_us_median", statistics.median(taken) * 1e6)
    print(f"a call there and back: {statistics.median(taken) * 1e6:.0f} µs")


# ---- it is reloaded -----------------------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("eager")
def test_it_is_reloaded_on_save(file: Path) -> None:
    """Good, other, broken, endless, good again: the arm does what the file says, and the problem goes when it works again. Some editors
    write into the file, others put a new one in its place."""
    saves = 0

    def save(text: str) -> None:
        nonlocal saves
        saves += 1
        if saves % 2:
            os.replace(write(file.with_suffix(".tmp"), text), file)
        else:
            write(file, text)

    save(GOOD)
    with OwnLaw(file, SHORT) as law:
        pids: set[int | None] = set()

        def moves(factor: float) -> bool:
            law.refresh()
            pids.add(law.pid)
            return bool(np.array_equal(law(SITUATION), SITUATION.nominal * factor))

        until(lambda: moves(2))
        save(GOOD.replace("2", "3.5"))
        until(lambda: moves(3.5))
        save("def law(s)\n")
        until(lambda: moves(0) and law.problem)
        assert law.problem is not None and "SyntaxError" in law.problem.text
        save("def law(s):\n    while True: pass")
        until(lambda: moves(0) and law.problem is not None and "endless" in law.problem.text)
        save("# Now it is right.\n" + GOOD)
        until(lambda: moves(2))
        assert law.problem is None
        assert len(pids - {None}) == 5
        living = [pid for pid in pids if pid is not None and not gone(pid)]
        assert living == [law.pid]


@pytest.mark.usefixtures("eager")
def test_what_is_no_news(file: Path) -> None:
    """The same text saved again, and a file that is away for a moment, as some editors have it, leave the process alone."""
    with OwnLaw(write(file, GOOD), waits=True) as law:
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


def test_the_file_is_not_looked_at_all_the_time(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """At most every 0.5 s, however often it is asked."""
    looks: list[float] = []
    now = 100.0
    monkeypatch.setattr(own_law_module, "monotonic", lambda: now)
    with OwnLaw(write(file, GOOD)) as law:
        monkeypatch.setattr(own_law_module, "_stamp", lambda path: looks.append(now))
        for i in range(100):
            now = 100.0 + 0.02 * i
            law.refresh()
    assert len(looks) == 3 and min(np.diff(looks)) >= 0.5


@pytest.mark.usefixtures("eager")
def test_nothing_is_started_before_it_is_needed(file: Path) -> None:
    """A session that has the law but never uses it costs nothing; a file that is saved meanwhile counts when it does."""
    with OwnLaw(write(file, "def law(s)")) as law:
        write(file, GOOD)
        assert law.refresh() and law.pid is None and not law.ready and law.problem is None
        until(lambda: np.any(law(SITUATION)))


@pytest.mark.usefixtures("eager")
def test_a_broken_file_is_noticed_while_nothing_moves_and_so_is_a_mended_one(file: Path) -> None:
    """Paused: nobody calls the law, and the message comes, changes and goes all the same."""
    with OwnLaw(write(file, GOOD), SHORT) as law:
        until(lambda: np.any(law(SITUATION)))
        write(file, "def law(s)")
        until(lambda: law.refresh() or law.problem is not None)
        until(lambda: law.refresh() or law.problem is not None)
        assert law.problem is not None and law.problem.line == 1
        write(file, "# It can be read now.\ndef law(s):\n    return s.nominal / 0 + undefined")
        until(lambda: law.refresh() or (law.problem is not None and law.problem.line == 3))
        until(lambda: law.refresh() or (law.problem is not None and law.problem.line == 3))
        write(file, GOOD)
        until(lambda: law.refresh() or law.problem is None)
        until(lambda: law.refresh() or law.problem is None)
        assert law.ready
        write(file, "def law(s):\n    while True: pass")
        until(lambda: law.refresh() or law.problem is not None)
        until(lambda: law.refresh() or law.problem is not None)
        assert law.problem is not None and "endless loop" in law.problem.text


# ---- nothing is left ----------------------------------------------------------------------------------------------------------


def test_no_process_is_left(file: Path) -> None:
    """After close, after a `with`, and when nobody knows it any more; closing twice is closing once."""
    write(file, GOOD)
    law = OwnLaw(file, waits=True)
    law(SITUATION)
    pid = law.pid
    law.close()
    law.close()
    assert pid is not None and gone(pid)
    assert_array_equal(law(SITUATION), ZEROS)
    law.restart()
    assert law.pid is None and not law.refresh()
    forgotten = OwnLaw(file, waits=True)
    forgotten(SITUATION)
    pid = forgotten.pid
    del forgotten
    gc.collect()
    assert pid is not None and gone(pid)


@pytest.mark.parametrize("end", ["closed", "dead"])
def test_what_the_law_started_goes_with_it(file: Path, end: str) -> None:
    """When it is closed, and when it has gone by itself."""
    text = """
        import os, subprocess, sys
        child = subprocess.Popen([sys.executable, "-SE", "-c", "input()"], stdin=subprocess.PIPE)

        def law(s):
            if s.distance < 0:
                os._exit(0)
            return s.nominal * 0 + child.pid
    """
    with OwnLaw(write(file, text), waits=True) as law:
        grandchild = int(law(SITUATION)[0])
        assert not gone(grandchild)
        if end == "dead":
            law(SITUATION._replace(distance=-0.1))
            assert law.problem is not None and "exit code 0" in law.problem.text
            until(lambda: gone(grandchild))
    until(lambda: gone(grandchild))


@pytest.mark.parametrize("end", ["os.kill(os.getpid(), 9)", "sys.exit()"])
def test_it_goes_with_the_page(file: Path, end: str) -> None:
    """However the page's process ends, and even in the middle of an endless loop."""
    write(file, "while True: pass")
    page = f"""
        import os, sys
        from pathlib import Path
        from app.own_law.child import Child
        from app.own_law.wire import pack_file
        path = Path({str(file)!r})
        child = Child(path, 2**28)
        assert child.line.receive(60.0) is not None
        child.line.send(pack_file(path.read_bytes()))
        print(child.pid, flush=True)
        {end}
    """
    root = Path(__file__).parents[3]
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(page)], cwd=root, capture_output=True, text=True, timeout=120.0, check=False
    )
    assert done.stdout.strip().isdigit(), done.stderr
    until(lambda: gone(int(done.stdout)))
