"""A file of which nothing is trusted, put through the six tests: in a process that is watched and killed with all that it started."""

import contextlib
import json
import os
import queue
import secrets
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import IO, Any, Final

import app
from app.custom_law.examination import examine
from app.custom_law.isolation import PROCESSES, guard_memory
from app.custom_law.law_limits import LawLimits
from app.custom_law.trials import TRIALS
from scenes.children import ONE_THREAD

_ROOT: Final = Path(app.__file__).resolve().parent.parent
_LOOK: Final = 0.05
"""Time between two looks at what a file has started [s]."""
_MOST: Final = 2**20
"""Characters that the tests of a file may say."""
_TOKEN: Final = "DUET_MARKING"
"""Name in the environment by which everything that a file has started is found."""
_KEPT: Final = ("PATH", "SYSTEMROOT", "LD_LIBRARY_PATH")
"""Of the environment."""


@dataclass(frozen=True)
class MarkingLimits:
    """What the tests of one file may take.

    Attributes:
        seconds: wall time of all six together [s].
        memory: of all processes together [bytes].
        processes: at a time.
        law: of each call.
        isolated: whether to run it in namespaces of its own, where the system allows it.
    """

    seconds: float = 120.0
    memory: int = 1536 * 2**20
    processes: int = PROCESSES
    law: LawLimits = LawLimits()  # noqa: RUF009 (frozen)
    isolated: bool = True


@dataclass
class LawMarks:
    """What came out for one file.

    Attributes:
        passed: whether each test was passed, by name; a test that was not made is missing.
        reasons: why a test failed, by name.
        ended: why the tests were not all made; "" if they were.
        isolation: "full", "network" or "none"; "" if nothing was run.
    """

    passed: dict[str, bool] = field(default_factory=dict)
    reasons: dict[str, str] = field(default_factory=dict)
    ended: str = ""
    isolation: str = ""


def marked(
    name: str,
    text: bytes,
    limits: MarkingLimits = MarkingLimits(),
    stopped: Callable[[], bool] = lambda: False,
) -> LawMarks:
    """Return the marks of a file.

    Args:
        name: of the file, for its messages.
        text: what it holds.
        stopped: asked now and then whether to give up.
    """
    marks = LawMarks()
    with tempfile.TemporaryDirectory(prefix="duet-marking-", ignore_cleanup_errors=True) as folder:
        token = secrets.token_hex(8)
        process = _started(folder, name, token, limits)
        lines: queue.Queue[str | None] = queue.Queue()
        for work, arguments in ((_feed, (process.stdin, text)), (_read, (process.stdout, lines))):
            threading.Thread(target=work, args=arguments, daemon=True).start()
        try:
            why = _followed(lines, marks, token, limits, stopped)
        finally:
            _end(process, token)
    if len(marks.passed) < len(TRIALS):
        marks.ended = why or f"the process of the tests ended (exit code {process.returncode})"
    return marks


def _started(folder: str, name: str, token: str, limits: MarkingLimits) -> "subprocess.Popen[bytes]":
    environment = {key: os.environ[key] for key in _KEPT if key in os.environ} | ONE_THREAD
    environment |= {"PYTHONPATH": str(_ROOT), "PYTHONDONTWRITEBYTECODE": "1", "PYTHONUTF8": "1", _TOKEN: token}
    environment |= dict.fromkeys(("HOME", "TMPDIR", "TEMP", "TMP"), folder)
    python = [sys.executable, "-P", "-m"]
    tests = [*python, "app.custom_law.marked", json.dumps(asdict(limits.law)), name]
    return subprocess.Popen(
        [*python, "app.custom_law.isolation", "all" if limits.isolated else "none", folder, _seen(), *tests],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
        env=environment,
        cwd=_ROOT,
    )


def _seen() -> str:
    """Return what the tests read beside the system: Python, its packages, and our own."""
    pythons = {Path(place) for place in (sys.prefix, sys.base_prefix, Path(sys.executable).resolve().parent.parent)}
    libraries = map(Path, filter(os.path.isabs, os.environ.get("LD_LIBRARY_PATH", "").split(os.pathsep)))
    paths = [
        *(python / part for python in pythons for part in ("bin", "lib", "lib64", "pyvenv.cfg")),
        *(_ROOT / part for part in ("app", "controllers", "scenes")),
        *(Path(place) for place in sys.path if Path(place).name in ("site-packages", "dist-packages")),
        *libraries,
    ]
    return os.pathsep.join(sorted({str(place) for path in paths for place in (path, path.resolve())}))


def _feed(stream: IO[bytes], text: bytes) -> None:
    with contextlib.suppress(OSError), stream:
        stream.write(text)


def _read(stream: IO[bytes], lines: "queue.Queue[str | None]") -> None:
    """Put each line into a queue, then None; more than `_MOST` is not read."""
    left = _MOST
    with contextlib.suppress(OSError, ValueError):
        while left > 0 and (line := stream.readline(left)):
            left -= len(line)
            lines.put(line.decode(errors="replace"))
    lines.put(None)


def _followed(
    lines: "queue.Queue[str | None]", marks: LawMarks, token: str, limits: MarkingLimits, stopped: Callable[[], bool]
) -> str:
    """Take in the verdicts until there are no more; return why they were given up, "" if they were not."""
    end = time.monotonic() + limits.seconds
    while time.monotonic() < end:
        with contextlib.suppress(queue.Empty):
            line = lines.get(timeout=_LOOK)
            if line is None:
                return ""
            _take(line, marks)
        if stopped():
            return "given up"
        members = _members(token)
        if len(members) > limits.processes:
            return f"it started more than {limits.processes} processes"
        if sum(map(_memory, members)) > limits.memory:
            return f"it took more than {limits.memory >> 20} MiB of memory"
    return f"the tests did not end within {limits.seconds:g} s"


def _take(line: str, marks: LawMarks) -> None:
    with contextlib.suppress(ValueError, KeyError, TypeError):
        said: dict[str, Any] = json.loads(line)
        if "isolation" in said:
            marks.isolation = str(said["isolation"])
        elif said["name"] in TRIALS:
            marks.passed[said["name"]] = said["passed"] is True
            if said["passed"] is not True:
                marks.reasons[said["name"]] = str(said["reason"])


def _members(token: str) -> list[int]:
    """Return the processes that a file has started, by the environment that they inherit; on Linux, elsewhere none."""
    found: list[int] = []
    wanted = f"{_TOKEN}={token}".encode()
    for name in os.listdir("/proc") if sys.platform == "linux" else ():
        if name.isdecimal():
            with contextlib.suppress(OSError), open(f"/proc/{name}/environ", "rb") as file:
                if wanted in file.read(65536):
                    found.append(int(name))
    return found


def _memory(process: int) -> int:
    """Return the memory of a process that it does not share with files [bytes]."""
    with contextlib.suppress(OSError, ValueError, IndexError), open(f"/proc/{process}/statm", encoding="ascii") as file:
        _, resident, shared, *_ = map(int, file.read().split())
        return (resident - shared) * os.sysconf("SC_PAGESIZE")
    return 0


def _end(process: "subprocess.Popen[bytes]", token: str) -> None:
    """Kill a process and everything that it started."""
    if hasattr(os, "killpg"):
        # Its id is its own until it is waited for.
        with contextlib.suppress(OSError):
            os.killpg(process.pid, signal.SIGKILL)
    else:
        process.kill()
    process.wait()
    end = time.monotonic() + 5.0
    while (members := _members(token)) and time.monotonic() < end:
        for member in members:
            # Its whole group at once: what forks and forks is killed one by one too slowly.
            with contextlib.suppress(OSError):
                os.killpg(os.getpgid(member), signal.SIGKILL)
        time.sleep(0.001)
    for stream in (process.stdout, process.stdin):
        if stream is not None:
            with contextlib.suppress(OSError):
                stream.close()


def main() -> None:
    """Make the tests."""
    limits, name, level = sys.argv[1:]
    guard_memory()
    text = sys.stdin.buffer.read()
    _write({"isolation": level})
    for verdict in examine(Path(name), LawLimits(**json.loads(limits)), text=text):
        _write(asdict(verdict) | {"reason": str(verdict.reason)})


def _write(line: Mapping[str, object]) -> None:
    print(json.dumps(line), flush=True)


if __name__ == "__main__":
    main()
