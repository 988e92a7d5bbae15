"""A failing custom law at worst freezes its arm: its line is named, no call waits, no process remains."""

import gc
import os
import re
import signal
import subprocess
import sys
import textwrap
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from app.features.custom_law.custom_law import CustomLaw
from app.features.custom_law.law_limits import LawLimits
from controllers.errors import BadInputFile
from controllers.laws.situation import Unanswered
from tests.app.features.custom_law.helpers import GOOD, SHORT, SITUATION, ZEROS, frozen, soon, write
from tests.app.runtime.processes import gone, until
from tests.approved import Approve

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("def law(s):\n    return s.nominal / s.gain", "line 2: AttributeError: 'Situation' object has no attribute 'gain'"),
        ("import os\ndef law(s):\n    os._exit(3)", "my_law.py: it ended its own process (exit code 3); a law returns velocities"),
        ("import os\ndef law(s):\n    os.abort()", "line 3: its process crashed (SIGABRT), in “os.abort()”"),
        ("import ctypes\ndef law(s):\n    ctypes.string_at(0)", "line 3: its process crashed (SIGSEGV), in “ctypes.string_at(0)”"),
        ("import socket\ndef law(s):\n    for i in range(3, 20):\n        try:\n            socket.socket(fileno=i).send(bytes(99))\n"
         "        except OSError:\n            pass", "it wrote to the line between its process and the page"),
        ("import os\ndef law(s):\n    for i in range(3, 20):\n        try:\n            os.write(i, bytes(2))\n"
         "        except OSError:\n            pass\n    while True: pass", "it hung up the line between its process and the page"),
    ],
)  # fmt: skip
def test_a_failing_law_is_named_with_its_reason(file: Path, text: str, says: str) -> None:
    """Failures in a call, while loading, and without an exception; `test_law_file` has the others."""
    said = frozen(CustomLaw(write(file, text), waits=True))
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
    ids=["python", "python, not waited for", "asleep", "below", "while it is read", "activation"],
)
def test_an_endless_loop_is_ended_and_named(
    file: Path, text: str, line: tuple[int, ...], waits: bool, approve: Approve
) -> None:
    with CustomLaw(write(file, text), SHORT, waits) as law:
        pids: set[int | None] = set()

        def given_up() -> bool:
            law.refresh()
            assert not np.any(soon(law)) or "activation" in text
            pids.add(law.pid)
            return law.problem is not None

        until(given_up)
        assert law.problem is not None
        assert law.problem.line in line
        # The line at which the loop is stopped depends on the machine.
        said, _, _ = law.problem.text.partition(", in “")
        what = "read" if text.startswith("x = 1") else "called"
        approve(
            f"endless {what}.txt",
            re.sub(r"line \d+", "line …", said) + law.problem.text.rpartition("”")[2] + "\n",
        )
        assert all(pid is None or gone(pid) for pid in pids)


@pytest.mark.skipif(sys.platform != "linux", reason="only there is a process's memory counted")
@pytest.mark.parametrize(
    "hog",
    [
        "np.zeros(10**10)",
        "[bytearray(10**6) for _ in range(10**6)]",
        "kept.append(bytearray(30 * 10**6)) or s.nominal",
    ],
    ids=["at once", "piece by piece", "call by call"],
)
def test_a_memory_hog_is_ended_and_named(file: Path, hog: str, approve: Approve) -> None:
    text = f"import numpy as np\nkept = []\n\ndef law(s):\n    return {hog}"
    with CustomLaw(write(file, text), replace(SHORT, load=5.0, call=5.0), waits=True) as law:
        assert law.load()
        pid = law.pid
        for _ in range(10):
            law(SITUATION)
        assert law.problem is not None and pid is not None and gone(pid)
        assert law.problem.line == 5
        approve("memory.txt", law.problem.text.partition(", in “")[0] + "\n")


def test_broken_law_processes_are_reported_and_restarted(file: Path) -> None:
    # Open files of the page's process do not change what the law can break in its own process.
    text = "import os\ndef law(s):\n    os.closerange(3, 20)"
    opened = [os.open(os.devnull, os.O_RDONLY) for _ in range(100)]
    try:
        assert "it hung up the line" in frozen(CustomLaw(write(file, text), waits=True))
    finally:
        for number in opened:
            os.close(number)
    # The process is killed from outside.
    with CustomLaw(write(file, GOOD), waits=True) as law:
        law(SITUATION)
        assert law.pid is not None
        os.kill(law.pid, signal.SIGKILL)
        assert_array_equal(law(SITUATION), ZEROS)
        assert law.problem is not None and "ended from outside" in law.problem.text
        law.restart()
        assert_array_equal(law(SITUATION), SITUATION.nominal * 2)
        assert law.problem is None
    # A law of 5 ms per call leaves the rest of its curve empty instead of delaying the page.
    text = "import time\ndef law(s):\n    time.sleep(0.005)\n    return s.nominal"
    with CustomLaw(write(file, text), LawLimits(call=1.0), waits=True) as law:
        found = law.line_rates(np.linspace(0.0, 0.6, 100), 0.1, 0.0, 1.0)
        assert found[0] == pytest.approx(-0.1) and np.isnan(found[-1])
        assert law.problem is None


def test_unusable_paths_are_refused(tmp_path: Path) -> None:
    for path, says in (
        (tmp_path / "no.py", "there is no such file; `lwr-duet new-law no.py` writes one"),
        (tmp_path, "cannot be read"),
        (write(tmp_path / "large.py", "#" * (2**20 + 1)), "larger than 1 MiB"),
    ):
        with pytest.raises(BadInputFile, match=says):
            CustomLaw(path)


def test_a_python_that_cannot_be_started(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for executable, says in ((str(file.parent / "python"), "No such file"), ("/bin/false", "exit code 1")):
        monkeypatch.setattr(sys, "executable", executable)
        with CustomLaw(write(file, GOOD), waits=True) as law:
            assert_array_equal(law(SITUATION), ZEROS)
            assert (
                law.problem is not None
                and "could not be started" in law.problem.text
                and says in law.problem.text
            )


def test_a_slow_start_delays_no_call(file: Path, tmp_path: Path) -> None:
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
    with CustomLaw(write(file, text), LawLimits(load=30.0, call=0.01)) as law:
        for _ in range(100):
            with pytest.raises(Unanswered):
                law(SITUATION)
        assert law.problem is None and not law.ready
        until(lambda: law.waiting)
        (tmp_path / "read").touch()
        until(lambda: law.ready)
        for _ in range(100):
            with pytest.raises(Unanswered):
                law(SITUATION)
        assert law.problem is None and law.waiting
        (tmp_path / "call").touch()
        until(lambda: np.array_equal(soon(law), SITUATION.nominal * 2))
        law.refresh()
        assert not law.waiting
        assert law.problem is None


def test_no_process_remains(file: Path) -> None:
    write(file, GOOD)
    law = CustomLaw(file, waits=True)
    law(SITUATION)
    pid = law.pid
    law.close()
    law.close()
    assert pid is not None and gone(pid)
    assert_array_equal(law(SITUATION), ZEROS)
    law.restart()
    assert law.pid is None and not law.refresh()
    forgotten = CustomLaw(file, waits=True)
    forgotten(SITUATION)
    pid = forgotten.pid
    del forgotten
    gc.collect()
    assert pid is not None and gone(pid)


@pytest.mark.parametrize("end", ["closed", "dead"])
def test_processes_started_by_the_law_end_with_it(file: Path, end: str) -> None:
    text = """
        import os, subprocess, sys
        child = subprocess.Popen([sys.executable, "-SE", "-c", "input()"], stdin=subprocess.PIPE)

        def law(s):
            if s.distance < 0:
                os._exit(0)
            return s.nominal * 0 + child.pid
    """
    # On a busy machine its end takes longer than an answer may.
    with CustomLaw(write(file, text), LawLimits(call=5.0), waits=True) as law:
        grandchild = int(law(SITUATION)[0])
        assert not gone(grandchild)
        if end == "dead":
            law(SITUATION._replace(distance=-0.1))
            assert law.problem is not None and "exit code 0" in law.problem.text
            until(lambda: gone(grandchild))
    until(lambda: gone(grandchild))


@pytest.mark.parametrize("end", ["os.kill(os.getpid(), 9)", "sys.exit()"])
def test_the_law_process_ends_with_the_page(file: Path, end: str) -> None:
    write(file, "while True: pass")
    page = f"""
        import os, sys
        from pathlib import Path
        from app.features.custom_law.law_limits import LawLimits
        from app.features.custom_law.process import LawProcess
        path = Path({str(file)!r})
        process = LawProcess(path, path.read_bytes(), LawLimits(start=60.0))
        while process._phase == "starting":
            process.ready(False)
        print(process.pid, flush=True)
        {end}
    """
    command, root = [sys.executable, "-c", textwrap.dedent(page)], Path(__file__).parents[4]
    done = subprocess.run(command, cwd=root, capture_output=True, text=True, timeout=120.0, check=False)
    assert done.stdout.strip().isdigit(), done.stderr
    until(lambda: gone(int(done.stdout)))
