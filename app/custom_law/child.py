"""Child processes for laws: start one, read where it is, end it with its descendants. On Linux, macOS and Windows."""

import contextlib
import multiprocessing
import os
import re
import select
import signal
import socket
import struct
import subprocess
import sys
import time
import weakref
from multiprocessing.connection import Connection
from pathlib import Path
from typing import IO, Final

import app
from app.custom_law.law_file import FILENAME
from scenes.children import ONE_THREAD

_ROOT: Final = str(Path(app.__file__).resolve().parent.parent)
_TRACE: Final = 0.2
"""Time that a process has for reporting where it is, before it is ended [s]."""
_IN_FILE: Final = re.compile(rb'File "' + re.escape(FILENAME).encode() + rb'", line (\d+)')
_MOST: Final = 65536
"""Largest report that is read [bytes]."""
_LARGEST: Final = 2**20
"""Largest message [bytes]."""
_STALLED: Final = 1
"""Time after which a message that is only half there, or half sent, breaks the connection [s]."""


class Child:
    """A process that runs `app.custom_law.worker`. It ends at the latest when this object is collected, or when this process ends.

    Args:
        memory: that the law may take [bytes].
    """

    def __init__(self, path: Path, memory: int) -> None:
        self.line, theirs = multiprocessing.Pipe()
        self._poll: select.poll | None = None
        handle, posix = theirs.fileno(), os.name == "posix"
        if posix:
            self._poll = select.poll()
            self._poll.register(self.line, select.POLLIN)
            _break_when_stalled(self.line)
        else:
            os.set_handle_inheritable(handle, True)  # pyright: ignore[reportAttributeAccessIssue]
        known = [_ROOT, *filter(None, [os.environ.get("PYTHONPATH")])]
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", "app.custom_law.worker", str(handle), str(memory), str(path)],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            pass_fds=(handle,) if posix else (),
            close_fds=posix,
            # Ctrl+C is for the page, and what the law starts goes with it.
            start_new_session=True,
            env=os.environ | ONE_THREAD | {"PYTHONPATH": os.pathsep.join(known)},
            cwd=path.parent,
        )
        theirs.close()
        self._end = weakref.finalize(self, _end, self._process, self.line)

    def receive(self, seconds: float) -> bytes | None:
        """Return the next message; None if it is not there in time [s].

        Raises:
            OSError, EOFError: the connection is broken.
        """
        # `Connection.poll` makes a selector at every call, which costs more than the message.
        there = self.line.poll(seconds) if self._poll is None else self._poll.poll(1e3 * seconds)
        return self.line.recv_bytes(_LARGEST) if there else None

    @property
    def pid(self) -> int:
        return self._process.pid

    def end(self) -> None:
        """End it and everything that it started; can be called again."""
        self._end()

    def place(self) -> int | None:
        """Return the line of the file that runs now; None if unknown. End it next."""
        if not hasattr(signal, "SIGUSR1"):
            return None
        with contextlib.suppress(OSError):
            self._process.send_signal(signal.SIGUSR1)
        return _line_in(self._trace())

    def last_words(self) -> tuple[int | None, str, int | None]:
        """Return its exit code (minus the signal that ended it; None if it lives), its last output, and the line of the file that ran;
        to be called when the connection is broken."""
        end = time.monotonic() + _TRACE
        while self._alive() and time.monotonic() < end:
            time.sleep(0.001)
        if not self._alive():
            # What it started, as long as its id is still its own.
            _kill(self._process)
        code, trace = self._process.poll(), self._trace()
        return code, trace.decode(errors="replace").strip(), _line_in(trace)

    def _alive(self) -> bool:
        """Return whether it runs; where the system can tell, without releasing its id."""
        if not hasattr(os, "waitid"):
            return self._process.poll() is None
        return os.waitid(os.P_PID, self.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is None

    def _trace(self) -> bytes:
        """Return its report of a crash or of its place: as soon as that names a line, or the process has ended, or `_TRACE` is over."""
        stream, report, end = self._process.stderr, b"", time.monotonic() + _TRACE
        assert stream is not None
        if os.name != "posix":
            return stream.read() if self._process.poll() is not None else b""
        os.set_blocking(stream.fileno(), False)
        while len(report) < _MOST and _line_in(report) is None:
            try:
                piece = os.read(stream.fileno(), _MOST)
            except BlockingIOError:
                if time.monotonic() > end or self._process.poll() is not None:
                    break
                time.sleep(0.001)
                continue
            if not piece:
                break
            report += piece
        return report


def _break_when_stalled(line: Connection) -> None:
    """Limit the time of every read and write, so that a law which writes to the connection itself cannot block the page."""
    with socket.fromfd(line.fileno(), socket.AF_UNIX, socket.SOCK_STREAM) as end:
        for option in (socket.SO_RCVTIMEO, socket.SO_SNDTIMEO):
            end.setsockopt(socket.SOL_SOCKET, option, struct.pack("ll", _STALLED, 0))


def _line_in(trace: bytes) -> int | None:
    found = _IN_FILE.search(trace)
    return int(found[1]) if found else None


def _end(process: "subprocess.Popen[bytes]", line: Connection) -> None:
    line.close()
    _kill(process)
    with contextlib.suppress(subprocess.TimeoutExpired):
        process.wait(1.0)
    streams: tuple[IO[bytes] | None, ...] = (process.stdin, process.stderr)
    for stream in streams:
        if stream is not None:
            with contextlib.suppress(OSError):
                stream.close()


def _kill(process: "subprocess.Popen[bytes]") -> None:
    """Kill a process and its descendants, unless it was reaped: then its id may belong to another process."""
    if process.returncode is not None:
        return
    with contextlib.suppress(OSError):
        if hasattr(os, "killpg"):
            os.killpg(process.pid, signal.SIGKILL)
        else:
            process.kill()
