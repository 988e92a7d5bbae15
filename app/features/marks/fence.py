"""Run an untrusted file in a watched process, and kill all that it started."""

import contextlib
import json
import os
import queue
import secrets
import signal
import subprocess
import sys
import threading
import time
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import IO, Any, Final

from app.features.custom_law.law_limits import LawLimits
from app.features.custom_law.process import kill_group
from app.features.marks.isolation import PROCESSES, guard_memory
from app.runtime.temporary_folder import TemporaryFolder
from controllers.compiled import READ, loops_folder
from controllers.errors import LazyText
from controllers.own_packages import FOLDER, PACKAGES, own_command
from scenes.children import ONE_THREAD

_LOOK: Final = 0.05
"""Period of the checks [s]."""
_MOST: Final = 2**20
"""Most characters of output."""
_TOKEN: Final = "DUET_FENCE"
"""Environment variable that marks a file's processes."""
_KEPT: Final = ("PATH", "SYSTEMROOT", "LD_LIBRARY_PATH")


@dataclass(frozen=True)
class FenceLimits:
    """Limits for one file.

    Attributes:
        seconds: wall time [s].
        memory: of all processes together [bytes].
        law: of each call.
        isolated: use new namespaces if possible.
    """

    seconds: float = 120.0
    memory: int = 1536 * 2**20
    law: LawLimits = LawLimits()  # noqa: RUF009 (frozen)
    isolated: bool = True


def fenced(
    module: str,
    arguments: Sequence[str],
    text: bytes,
    take: Callable[[dict[str, Any]], None],
    limits: FenceLimits = FenceLimits(),
    stopped: Callable[[], bool] = lambda: False,
) -> str:
    """Run a module on the text of a file. Returns why it ended, as a `LazyText`; relevant only if answers are
    missing.

    Args:
        module: its `main` reads by `fenced_input` and answers by `say`.
        take: gets each answer; its `ValueError`, `KeyError` and `TypeError` are ignored, as answers may be
            forged.
        stopped: polled; True gives up.
    """
    with TemporaryFolder("fence") as folder:
        token = secrets.token_hex(8)
        process = _started(
            str(folder.path), [module, json.dumps(asdict(limits.law)), *arguments], token, limits
        )
        lines: queue.Queue[str | None] = queue.Queue()
        for work, given in ((_feed, (process.stdin, text)), (_read, (process.stdout, lines))):
            threading.Thread(target=work, args=given, daemon=True).start()
        try:
            why = _followed(lines, take, partial(_members, token, process.pid), limits, stopped)
        finally:
            _end(process, token)
    return why or LazyText("its process ended (exit code {code})", code=process.returncode)


def isolation_of(limits: FenceLimits) -> str:
    """Isolation "full", "network" or "none"; "" if no process can be started."""
    levels: list[str] = []
    fenced(__name__, [], b"", lambda said: levels.append(str(said["isolation"])), limits)
    return levels[0] if levels else ""


def fenced_input() -> tuple[LawLimits, list[str], bytes]:
    """In the fenced process: limits, arguments and file text; reports the isolation."""
    limits, *arguments, level = sys.argv[1:]
    guard_memory()
    text = sys.stdin.buffer.read()
    say({"isolation": level})
    return LawLimits(**json.loads(limits)), arguments, text


def say(answer: Mapping[str, object]) -> None:
    """In the fenced process: answer."""
    print(json.dumps(answer), flush=True)


def _started(folder: str, work: list[str], token: str, limits: FenceLimits) -> "subprocess.Popen[bytes]":
    environment = {key: os.environ[key] for key in _KEPT if key in os.environ} | ONE_THREAD
    environment |= {"PYTHONDONTWRITEBYTECODE": "1", "PYTHONUTF8": "1", _TOKEN: token}
    for place in _machine_code():
        environment[READ] = str(place.parent)
    environment |= dict.fromkeys(("HOME", "TMPDIR", "TEMP", "TMP"), folder)
    level = "all" if limits.isolated else "none"
    return subprocess.Popen(
        own_command("app.features.marks.isolation", level, folder, _seen(), *own_command(*work)),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
        env=environment,
        cwd=folder,
    )


def _seen() -> str:
    """Folders that the file may read: Python, its packages and Duet."""
    pythons = {
        Path(place) for place in (sys.prefix, sys.base_prefix, Path(sys.executable).resolve().parent.parent)
    }
    libraries = map(Path, filter(os.path.isabs, os.environ.get("LD_LIBRARY_PATH", "").split(os.pathsep)))
    paths = [
        *(python / part for python in pythons for part in ("bin", "lib", "lib64", "pyvenv.cfg")),
        *(Path(FOLDER, package) for package in PACKAGES),
        *(Path(place) for place in sys.path if Path(place).name in ("site-packages", "dist-packages")),
        *libraries,
        *_machine_code(),
    ]
    return os.pathsep.join(sorted({str(place) for path in paths for place in (path, path.resolve())}))


def _machine_code() -> list[Path]:
    """Compiled loops; empty if unavailable."""
    try:
        return [loops_folder()]
    except (ImportError, OSError):
        return []


def _feed(stream: IO[bytes], text: bytes) -> None:
    with contextlib.suppress(OSError), stream:
        stream.write(text)


def _read(stream: IO[bytes], lines: "queue.Queue[str | None]") -> None:
    left = _MOST
    with contextlib.suppress(OSError, ValueError):
        while left > 0 and (line := stream.readline(left)):
            left -= len(line)
            lines.put(line.decode(errors="replace"))
    lines.put(None)


def _followed(
    lines: "queue.Queue[str | None]",
    take: Callable[[dict[str, Any]], None],
    started: Callable[[], list[int]],
    limits: FenceLimits,
    stopped: Callable[[], bool],
) -> str:
    """Handle all answers. Returns why it gave up, or ""."""
    end = time.monotonic() + limits.seconds
    while time.monotonic() < end:
        with contextlib.suppress(queue.Empty):
            line = lines.get(timeout=_LOOK)
            if line is None:
                return ""
            with contextlib.suppress(ValueError, KeyError, TypeError):
                take(json.loads(line))
        if stopped():
            return LazyText("given up")
        members = started()
        if len(members) > PROCESSES:
            return LazyText("it started more than {count} processes", count=PROCESSES)
        if sum(map(_memory, members)) > limits.memory:
            return LazyText("it took more than {size} MiB of memory", size=limits.memory >> 20)
    return LazyText("it did not end within {seconds:g} s", seconds=limits.seconds)


def _members(token: str, first: int | None = None) -> list[int]:
    """Processes that a file has started; Linux only.

    Args:
        token: in the environment that they inherit, unless they replace it.
        first: its descendants count, too; or None.
    """
    found: list[int] = []
    children: defaultdict[int, list[int]] = defaultdict(list)
    wanted = f"{_TOKEN}={token}".encode()
    for name in os.listdir("/proc") if sys.platform == "linux" else ():
        if name.isdecimal():
            with contextlib.suppress(OSError, ValueError, IndexError):
                # Its name, in parentheses, may contain any character.
                state, parent, *_ = Path("/proc", name, "stat").read_bytes().rpartition(b")")[2].split()
                if state != b"Z":
                    children[int(parent)].append(int(name))
            with contextlib.suppress(OSError), open(f"/proc/{name}/environ", "rb") as file:
                if wanted in file.read(65536):
                    found.append(int(name))
    below = [] if first is None else children[first]
    while below:
        found += below
        below = [child for parent in below for child in children[parent]]
    return list(set(found))


def _memory(process: int) -> int:
    """Memory not shared with files, and of unnamed files [bytes]."""
    memory = 0
    with (
        contextlib.suppress(OSError, ValueError, IndexError),
        open(f"/proc/{process}/status", encoding="utf-8") as file,
    ):
        for line in file:
            if line.startswith(("RssAnon:", "RssShmem:")):
                memory += int(line.split()[1]) * 1024
    # Only root may read these of a guarded process; other processes' files use memory even if unmapped.
    with contextlib.suppress(OSError):
        for name in os.listdir(f"/proc/{process}/fd"):
            with contextlib.suppress(OSError):
                if os.readlink(f"/proc/{process}/fd/{name}").startswith("/memfd:"):
                    memory += os.stat(f"/proc/{process}/fd/{name}").st_blocks * 512
    return memory


def _end(process: "subprocess.Popen[bytes]", token: str) -> None:
    members = _members(token, process.pid)
    kill_group(process)
    _kill(members)
    process.wait()
    end = time.monotonic() + 5.0
    while (members := _members(token)) and time.monotonic() < end:
        _kill(members)
        time.sleep(0.001)
    for stream in filter(None, (process.stdout, process.stdin)):
        with contextlib.suppress(OSError):
            stream.close()


def _kill(members: list[int]) -> None:
    for member in members:
        # Its whole group at once: killing one by one is too slow for a process that keeps forking.
        with contextlib.suppress(OSError):
            os.killpg(os.getpgid(member), signal.SIGKILL)


def main() -> None:
    fenced_input()
