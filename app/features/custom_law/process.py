"""The page's side of a law's process."""

import contextlib
import math
import multiprocessing
import os
import re
import select
import signal
import socket
import struct
import subprocess
import time
import weakref
from collections import deque
from multiprocessing.connection import Connection
from pathlib import Path
from time import monotonic
from typing import Final, Literal, TypeVar

from app.features.custom_law.law_file import FILENAME, quoted
from app.features.custom_law.law_limits import LawLimits, LawProblem, Patience, problem_of
from app.features.custom_law.wire import (
    BROKEN,
    Failure,
    FileLoaded,
    LawQuestion,
    LoadFile,
    Numbers,
    Reply,
    Started,
    decode_reply,
    encode,
)
from controllers.errors import LazyText, joined
from controllers.own_packages import own_command
from scenes.children import ONE_THREAD
from scenes.files import readable

_TRACE: Final = 0.2
"""Time for a process to report its place [s]; extended while it waits for a core."""
_IN_FILE: Final = re.compile(rb'File "' + re.escape(FILENAME).encode() + rb'", line (\d+)')
_MOST: Final = 65536
"""Largest report [bytes]."""
_LARGEST: Final = 2**20
"""Largest message [bytes]."""
_STALLED: Final = 1
"""Time after which a partial message breaks the connection [s]."""


def _started(path: Path, memory: int) -> "tuple[subprocess.Popen[bytes], Connection]":
    """`memory`: limit [bytes]. Returns the process, and our end of the connection."""
    ours, theirs = multiprocessing.Pipe()
    handle, posix = theirs.fileno(), os.name == "posix"
    if posix:
        _break_when_stalled(ours)
    else:
        os.set_handle_inheritable(handle, True)  # pyright: ignore[reportAttributeAccessIssue]
    process = subprocess.Popen(
        own_command("app.features.custom_law.worker", str(handle), str(memory), str(path)),
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        pass_fds=(handle,) if posix else (),
        close_fds=posix,
        # Ctrl+C is for the page, and the law's descendants end with it.
        start_new_session=True,
        env=os.environ | ONE_THREAD,
        cwd=path.parent,
    )
    theirs.close()
    return process, ours


def _break_when_stalled(line: Connection) -> None:
    """Limit reads and writes, so that a law that writes to the connection cannot block the page."""
    with socket.fromfd(line.fileno(), socket.AF_UNIX, socket.SOCK_STREAM) as end:
        for option in (socket.SO_RCVTIMEO, socket.SO_SNDTIMEO):
            end.setsockopt(socket.SOL_SOCKET, option, struct.pack("ll", _STALLED, 0))


def _line_in(trace: bytes) -> int | None:
    found = _IN_FILE.search(trace)
    return int(found[1]) if found else None


def _end(process: "subprocess.Popen[bytes]", line: Connection) -> None:
    line.close()
    kill_group(process)
    with contextlib.suppress(subprocess.TimeoutExpired):
        process.wait(10.0)
    for stream in filter(None, (process.stdin, process.stderr)):
        with contextlib.suppress(OSError):
            stream.close()


def kill_group(process: "subprocess.Popen[bytes]") -> None:
    """Kill a process group, unless its leader was reaped: the id may belong to another."""
    if process.returncode is not None:
        return
    with contextlib.suppress(OSError):
        if hasattr(os, "killpg"):
            os.killpg(process.pid, signal.SIGKILL)
        else:
            process.kill()


_SLICE: Final = 0.02
"""Period of the limit's check while a call waits [s]."""
_LONG_SLICE: Final = 0.25
"""Period without a limit [s]: each check also waits for a core, see `examination`."""

_R = TypeVar("_R", bound=Reply)


class LawFailed(Exception):
    """The law failed; its process is gone."""

    def __init__(self, problem: LawProblem) -> None:
        super().__init__(problem.text)
        self.problem = problem


class LawProcess:
    """Runs `app.features.custom_law.worker` with one version of a file; it ends with this object.

    Attributes:
        seconds: time of the last call inside the law [s]; nan before the first answer.
        end: ends it and its descendants; can be called again.
    """

    def __init__(self, path: Path, text: bytes, limits: LawLimits) -> None:
        self.wants_all_pairs, self.has_activation = True, False
        self.seconds = float("nan")
        self._name, self._text, self._limits = readable(path.name), text, limits
        self._process, self._line = _started(path, limits.memory)
        self._poll: select.poll | None = None
        if os.name == "posix":
            self._poll = select.poll()
            self._poll.register(self._line, select.POLLIN)
        self.pid = self._process.pid
        self.end = weakref.finalize(self, _end, self._process, self._line)
        self._phase: Literal["starting", "loading", "ready"] = "starting"
        self._patience = Patience(self.pid, limits.start)
        self._asked: deque[LawQuestion] = deque()
        self._called: set[type[LawQuestion]] = set()

    def ready(self, wait: bool) -> bool:
        """True if the law can be asked; `wait` waits for that.

        Raises:
            LawFailed: the file cannot be used.
        """
        seconds = math.inf if wait else 0.0
        if self._phase == "starting":
            if self._receive(Started, seconds) is None:
                return False
            self._phase = "loading"
            self._patience = Patience(self.pid, self._limits.load)
            self._send(LoadFile(self._text))
        if self._phase == "loading":
            loaded = self._receive(FileLoaded, seconds)
            if loaded is None:
                return False
            self._phase = "ready"
            self.wants_all_pairs, self.has_activation = loaded.wants_all_pairs, loaded.has_activation
        return True

    @property
    def busy(self) -> bool:
        return bool(self._asked)

    def asked(self, kind: type[LawQuestion]) -> bool:
        return any(type(question) is kind for question in self._asked)

    def ask(self, question: LawQuestion) -> None:
        """Ask, once ready.

        Raises:
            LawFailed: the process is gone.
        """
        self._send(question)
        self._asked.append(question)
        if len(self._asked) == 1:
            self._be_patient()

    def answer(self, seconds: float) -> tuple[LawQuestion, Numbers] | None:
        """Oldest question with its answer; None if it is pending.

        Args:
            seconds: longest wait, up to the law's limit [s].

        Raises:
            LawFailed: an exception, an invalid result, no answer in time, or no process.
        """
        numbers = self._receive(Numbers, seconds) if self._asked else None
        if numbers is None:
            return None
        if numbers.seconds is not None:
            self.seconds = numbers.seconds
        question = self._asked.popleft()
        if self._asked:
            self._be_patient()
        return question, numbers

    def _be_patient(self) -> None:
        """The first question of a kind may load a library."""
        kind = type(self._asked[0])
        self._patience = Patience(self.pid, self._limits.call if kind in self._called else self._limits.load)
        self._called.add(kind)

    def _receive(self, kind: type[_R], seconds: float) -> _R | None:
        end, pause = monotonic() + seconds, _SLICE if seconds < math.inf else _LONG_SLICE
        while True:
            left = max(end - monotonic(), 0.0)
            body = self._body(min(left, pause))
            if body is None and self._patience.over:
                # It may have come while the clocks were read.
                body = self._body(0.0)
                if body is None:
                    raise self._too_long()
            if body is not None:
                return self._reply(kind, body)
            if left <= pause:
                return None

    def _reply(self, kind: type[_R], body: bytes) -> _R:
        try:
            reply = decode_reply(body)
            if isinstance(reply, kind):
                return reply
            if not isinstance(reply, Failure):
                raise ValueError("another reply")
            text, line = reply.text.text(), reply.line
        except ValueError:
            line = None
            text = LazyText(
                "it wrote to the line between its process and the page; descriptors are not its own"
            )
        raise self._lost(text, line)

    def _send(self, message: LoadFile | LawQuestion) -> None:
        try:
            self._line.send_bytes(encode(message))
        except OSError:
            raise self._died() from None

    def _body(self, seconds: float) -> bytes | None:
        try:
            # `Connection.poll` makes a selector at every call, which costs more than the message.
            there = self._line.poll(seconds) if self._poll is None else self._poll.poll(1e3 * seconds)
            return self._line.recv_bytes(_LARGEST) if there else None
        except (OSError, EOFError):
            raise self._died() from None

    def _lost(self, what: str, line: int | None = None) -> LawFailed:
        self.end()
        return LawFailed(problem_of(self._name, what, line))

    def _too_long(self) -> LawFailed:
        limit = self._patience.limit
        if self._phase == "starting":
            return self._lost(
                LazyText(
                    "its process was not up within {limit:g} s; is the computer overloaded? Save the file to try again",
                    limit=limit,
                )
            )
        line = self._place()
        parts = {"limit": limit * 1e3, "where": quoted(self._text, line)}
        if self._phase == "loading":
            what = LazyText(
                "reading the file did not end within {limit:g} ms{where}. Is there an endless loop?", **parts
            )
        else:
            what = LazyText("no answer within {limit:g} ms{where}. Is there an endless loop?", **parts)
        return self._lost(what, line)

    def _died(self) -> LawFailed:
        code, words, line = self._last_words()
        if self._phase == "starting":
            why = words.splitlines()[-1] if words else LazyText("exit code {code}", code=code)
            return self._lost(LazyText("its process could not be started: {error}", error=why))
        if code is None or code == BROKEN:
            what = LazyText(
                "it hung up the line between its process and the page; descriptors are not its own"
            )
        elif code >= 0:
            what = LazyText(
                "it ended its own process (exit code {code}); a law returns velocities, or raises an exception",
                code=code,
            )
        elif -code == getattr(signal, "SIGKILL", None):
            what = LazyText("its process was ended from outside; perhaps the computer had no memory left")
        else:
            what = LazyText("its process crashed ({signal})", signal=_signal_name(-code))
        return self._lost(joined((what, quoted(self._text, line)), ""), line)

    def _place(self) -> int | None:
        """Line of the file that runs now; then the process must be ended."""
        if not hasattr(signal, "SIGUSR1"):
            return None
        with contextlib.suppress(OSError):
            self._process.send_signal(signal.SIGUSR1)
        return _line_in(self._trace())

    def _last_words(self) -> tuple[int | None, str, int | None]:
        """Exit code (minus the signal; None if alive), last output, and last line of the file."""
        patience = Patience(self.pid, _TRACE)
        while self._alive() and not patience.over:
            time.sleep(0.001)
        if not self._alive():
            # Its descendants, while its id is still its own.
            kill_group(self._process)
        code, trace = self._process.poll(), self._trace()
        return code, trace.decode(errors="replace").strip(), _line_in(trace)

    def _alive(self) -> bool:
        """True if it runs; without releasing its id, if the system can tell."""
        if not hasattr(os, "waitid"):
            return self._process.poll() is None
        return os.waitid(os.P_PID, self.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is None

    def _trace(self) -> bytes:
        """Report of a crash or place, until it names a line, the process ends, or `_TRACE` is over."""
        stream, report, patience = self._process.stderr, b"", Patience(self.pid, _TRACE)
        assert stream is not None
        if os.name != "posix":
            return stream.read() if self._process.poll() is not None else b""
        os.set_blocking(stream.fileno(), False)
        while len(report) < _MOST and _line_in(report) is None:
            try:
                piece = os.read(stream.fileno(), _MOST)
            except BlockingIOError:
                if patience.over or self._process.poll() is not None:
                    break
                time.sleep(0.001)
                continue
            if not piece:
                break
            report += piece
        return report


def _signal_name(number: int) -> str:
    with contextlib.suppress(ValueError):
        return signal.Signals(number).name
    return f"signal {number}"
