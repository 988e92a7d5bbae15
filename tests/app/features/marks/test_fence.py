"""A fence around misbehaving laws: limits of memory, time and processes, and no way out."""

import os
import re
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from textwrap import dedent

import pytest

import app
from app.features.custom_law.examination import examine
from app.features.custom_law.law_limits import LawLimits
from app.features.marks.marked import marked
from app.i18n.catalogue import words_of
from controllers.errors import LazyText
from tests.app.features.custom_law.helpers import PAPER
from tests.app.features.marks.helpers import FORKS, TOO_MANY, posix, quick
from tests.approved import Approve

pytestmark = [pytest.mark.slow, posix, pytest.mark.usefixtures("nothing_is_left")]

LEAVES = (
    "import os, time\nif not os.fork():\n    os.setsid()\n    if not os.fork():\n        time.sleep(600)\n    os._exit(0)\n"
    "os.wait()\n1 / 0\n"
)


def full() -> bool:
    return quick("1/0").isolation == "full"


@pytest.mark.thorough
@pytest.mark.parametrize("isolated", [True, False])
def test_all_processes_of_a_file_end_with_it(isolated: bool) -> None:
    # `nothing_is_left` looks for remaining processes.
    marks = quick(FORKS, isolated=isolated, law=LawLimits(load=30.0))
    assert re.search(TOO_MANY, f"{marks.ended} {marks.verdicts}")
    assert len(quick(LEAVES, isolated=isolated).verdicts) == 6


def test_memory_and_time_of_the_whole_tree(approve: Approve) -> None:
    many = "import os, time\nfor _ in range(4):\n    os.fork()\na = bytearray(b'x') * (100 * 2**20)\ntime.sleep(60)\n"
    approve("memory.txt", f"{quick(many, memory=300 * 2**20, law=LawLimits(load=30.0)).ended}\n")
    marks = quick("import time\ntime.sleep(60)\n", seconds=2.0, law=LawLimits(load=30.0))
    assert marks.verdicts == {}
    approve("late.txt", f"{marks.ended}\n{words_of('de')(marks.ended)}\n")


LARGE = "import sys, time\na = bytearray(b'x') * (400 * 2**20)\ntime.sleep(200)\n"
HIDDEN = {
    "shared": "import mmap\na = mmap.mmap(-1, 400 * 2**20)\nfor _ in range(25):\n    a.write(b'x' * 2**24)\n",
    "another environment": f"import subprocess, sys\nsubprocess.Popen([sys.executable, '-c', {LARGE!r}], env={{}})\n",
    "an orphan": "import os, sys\nif not os.fork():\n    if not os.fork():\n        "
    f"os.execve(sys.executable, [sys.executable, '-c', {LARGE!r}], {{}})\n    os._exit(0)\n",
    "without a name": "import os\nfiles = [os.memfd_create('a') for _ in range(25)]\nfor one in files:\n    os.write(one, b'x' * 2**24)\n",
}
"""Places where a file may keep memory → a text that keeps 400 MiB there."""


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere nothing is measured")
@pytest.mark.parametrize("place", HIDDEN)
@pytest.mark.parametrize("isolated", [True, False])
def test_no_memory_is_hidden(place: str, isolated: bool, approve: Approve) -> None:
    text = f"{HIDDEN[place]}import time\ntime.sleep(200)\n"
    marks = quick(text, memory=300 * 2**20, isolated=isolated, seconds=120.0, law=LawLimits(load=100.0))
    approve("memory.txt", f"{marks.ended}\n")


@pytest.fixture(params=[0, 4], ids=["a core of its own", "a busy core"])
def busy(request: pytest.FixtureRequest) -> Iterator[None]:
    """If requested, bind this process and its children to one core shared with several busy processes."""
    if not request.param:
        yield
        return
    if not hasattr(os, "sched_setaffinity"):
        pytest.skip("this system does not bind processes to a core")
    cores = os.sched_getaffinity(0)
    with ExitStack() as opened:
        opened.callback(os.sched_setaffinity, 0, cores)
        os.sched_setaffinity(0, {min(cores)})
        for _ in range(request.param):
            # Killed by its id in any case.
            opened.callback(subprocess.Popen([sys.executable, "-c", "while True: pass"]).kill)
        yield


@pytest.mark.thorough
def test_a_law_that_changes_the_clock_is_not_quick(busy: None) -> None:
    clock = """
    import time
    import app.features.custom_law.law_file

    real = time.thread_time
    app.features.custom_law.law_file.perf_counter = time.perf_counter = time.monotonic = time.process_time = lambda: 0.0
    """
    for wait in ("time.sleep(0.003)", "while real() < end: pass"):
        slow = PAPER.replace(
            "(situation):\n", f"(situation):\n        end = real() + 0.003\n        {wait}\n", 1
        )
        verdict = next(examine(Path("law.py"), only=("quick",), text=dedent(clock + slow).encode()))
        assert isinstance(verdict.reason, LazyText) and isinstance(
            median := verdict.reason.parts["median"], float
        )
        assert not verdict.passed and median > 2.0, wait


def test_a_law_cannot_reach_our_files(tmp_path: Path) -> None:
    if not full():
        pytest.skip("this system gives no namespaces to a process")
    other, mine = tmp_path / "other.py", tmp_path / "mine"
    other.write_text("secret", encoding="utf-8")
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        tries = (
            f"open({str(mine)!r}, 'w')",
            f"open({app.__file__!r}, 'a')",
            f"open({str(other)!r})",
            f"os.listdir({str(Path.home())!r} + '/.config')",
            "open('/etc/passwd')",
            f"__import__('socket').create_connection(('127.0.0.1', {port}), 1.0)",
            "open(f'/proc/{os.getppid()}/mem', 'r+b')",
            "open(f'/proc/{os.getppid()}/fd/1', 'w')",
            f"os.kill({os.getpid()}, 0)",
            "os.setuid(0)",
        )
        lines = ["import os", "failed = []"]
        for one in tries:
            lines += [
                "try:",
                f"    {one}",
                "except OSError as error:",
                "    failed.append(type(error).__name__)",
            ]
        lines += [
            "open('here', 'w').write(os.environ['HOME'])",
            "raise RuntimeError(failed, os.getcwd() == os.environ['HOME'])",
        ]
        marks = marked("law.py", "\n".join(lines).encode())
    refused, gone = "PermissionError", "ProcessLookupError"
    nothing = "FileNotFoundError"
    errors = [nothing, "OSError", nothing, nothing, nothing, "OSError", refused, refused, gone, "OSError"]
    assert f"({errors}, True)" in marks.verdicts["smooth"].reason
    assert not mine.exists()
