"""A child process with a line to it: started, asked where it is, ended without a trace. On Linux, macOS and Windows alike."""

import contextlib
import os
import re
import signal
import socket
import subprocess
import sys
import time
import weakref
from pathlib import Path
from typing import IO, Any, Final

import app
from app.custom_law.law_file import FILENAME
from app.custom_law.wire import LawConnection
from scenes.children import ONE_THREAD

_ROOT: Final = str(Path(app.__file__).resolve().parent.parent)
_TRACE: Final = 0.2
"""How long a process that is about to go has for saying where it is [s]."""
_IN_FILE: Final = re.compile(rb'File "' + re.escape(FILENAME).encode() + rb'", line (\d+)')
_MOST: Final = 65536
"""What is read of that [bytes]."""


class Child:
    """A process that runs `app.custom_law.worker`. It is ended at the latest when nobody knows it any more, or when this process ends.

    Args:
        path: of the law's file.
        memory: that the law may take [bytes].

    Attributes:
        line: to it.
    """

    def __init__(self, path: Path, memory: int) -> None:
        ours, theirs = socket.socketpair()
        shared = hasattr(theirs, "share")
        end = "share" if shared else str(theirs.fileno())
        known = [_ROOT, *filter(None, [os.environ.get("PYTHONPATH")])]
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", "app.custom_law.worker", end, str(memory), str(path)],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            pass_fds=() if shared else (theirs.fileno(),),
            # Ctrl+C is for the page, and what the law starts goes with it.
            start_new_session=True,
            env=os.environ | ONE_THREAD | {"PYTHONPATH": os.pathsep.join(known)},
            cwd=path.parent,
        )
        if shared:
            self._share(theirs)
        theirs.close()
        self.line = LawConnection(ours)
        self._end = weakref.finalize(self, _end, self._process, self.line)

    def _share(self, end: Any) -> None:
        """Hand the other end over, on Windows."""
        data = end.share(self._process.pid)
        assert self._process.stdin is not None
        self._process.stdin.write(len(data).to_bytes(4, "little") + data)
        self._process.stdin.flush()

    @property
    def pid(self) -> int:
        """Id of the process."""
        return self._process.pid

    def end(self) -> None:
        """End it now, and everything that it started; nothing if that has been done."""
        self._end()

    def place(self) -> int | None:
        """Return the line of the file at which it is; None if it does not say. It is to be ended next."""
        if not hasattr(signal, "SIGUSR1"):
            return None
        with contextlib.suppress(OSError):
            self._process.send_signal(signal.SIGUSR1)
        return _line_in(self._trace())

    def last_words(self) -> tuple[int | None, str, int | None]:
        """Return its exit code (minus the signal that ended it; None if it lives), what it said in the end, and the line of the file
        at which that was; to be called when the line is dead."""
        end = time.monotonic() + _TRACE
        while self._alive() and time.monotonic() < end:
            time.sleep(0.001)
        if not self._alive():
            # What it started, as long as its number is still its own.
            _kill(self._process)
        code, trace = self._process.poll(), self._trace()
        return code, trace.decode(errors="replace").strip(), _line_in(trace)

    def _alive(self) -> bool:
        """Return whether it runs; where the system can tell, without letting go of its number."""
        if not hasattr(os, "waitid"):
            return self._process.poll() is None
        return os.waitid(os.P_PID, self.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is None

    def _trace(self) -> bytes:
        """Return what it said about a crash or its place, as soon as that names a line, or it has gone, or time is up."""
        stream, said, end = self._process.stderr, b"", time.monotonic() + _TRACE
        assert stream is not None
        if os.name != "posix":
            return stream.read() if self._process.poll() is not None else b""
        os.set_blocking(stream.fileno(), False)
        while len(said) < _MOST and _line_in(said) is None:
            try:
                piece = os.read(stream.fileno(), _MOST)
            except BlockingIOError:
                if time.monotonic() > end or self._process.poll() is not None:
                    break
                time.sleep(0.001)
                continue
            if not piece:
                break
            said += piece
        return said


def _line_in(trace: bytes) -> int | None:
    found = _IN_FILE.search(trace)
    return int(found[1]) if found else None


def _end(process: "subprocess.Popen[bytes]", line: LawConnection) -> None:
    """End a process and its descendants, and leave nothing open."""
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
    """Kill a process and its descendants, if nobody has waited for it: after that its number may be somebody else's."""
    if process.returncode is not None:
        return
    with contextlib.suppress(OSError):
        if hasattr(os, "killpg"):
            os.killpg(process.pid, signal.SIGKILL)
        else:
            process.kill()
