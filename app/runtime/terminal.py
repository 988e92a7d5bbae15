"""A command in a terminal: signals, output, encoding, log. Imports nothing slow."""

import codecs
import contextlib
import errno
import io
import logging
import os
import signal
import stat
import sys
import time
from collections.abc import Callable, Iterator
from types import FrameType
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer as Buffer

INTERRUPTED: Final = 130

TERMINATED: Final = 143

_PATIENCE: Final = 3.0
"""Time for an interrupted command's clean-up, in which further Ctrl+C are ignored [s]."""

_at_once = False
_interrupted: float | None = None
_code = INTERRUPTED


def terminated() -> bool:
    """True if SIGTERM ends this process, which may be restarted."""
    return _code == TERMINATED


@contextlib.contextmanager
def ending_at_once() -> Iterator[None]:
    """Ctrl+C ends the process at once: a library that is being imported may lose a KeyboardInterrupt, or
    print it.
    """
    global _at_once
    before, _at_once = _at_once, True
    try:
        yield
    finally:
        _at_once = before


def run_in_terminal(command: Callable[[], int]) -> int:
    """Run a command; exit code 130 after Ctrl+C, 143 after SIGTERM, 0 if the output's reader has gone, 1
    after a line on stderr if the output cannot be written.
    """
    global _at_once
    _at_once = True
    # A shell makes background processes ignore Ctrl+C.
    if signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:
        signal.signal(signal.SIGINT, _interrupt)
    signal.signal(signal.SIGTERM, _interrupt)
    _fill_descriptors()
    sys.stdout, sys.stderr = _stream(sys.stdout, raises=True), _stream(sys.stderr, raises=False)
    code = 0
    try:
        try:
            _at_once = False
            code = command()
        except KeyboardInterrupt:
            code = INTERRUPTED
        finally:
            _at_once = True
            sys.stdout.flush()
    except OutputLost as lost:
        if lost.errno != errno.EPIPE:
            print(f"lwr-duet: the output cannot be written ({lost.strerror}).", file=sys.stderr)
            code = code or 1
        elif code != INTERRUPTED:
            code = 0
    if _interrupted is not None:
        # At its very end Python gives the signal back to the system, which changes the exit code.
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    return TERMINATED if terminated() else code


def _interrupt(number: int, frame: FrameType | None) -> None:
    global _interrupted, _code
    now = time.monotonic()
    if _interrupted is not None and now - _interrupted < _PATIENCE:
        return
    if _interrupted is None and number == signal.SIGTERM:
        _code = TERMINATED
    elif _interrupted is None and os.isatty(2):
        # The prompt comes below the ^C.
        os.write(2, b"\n")
    if _at_once or _interrupted is not None:
        os._exit(_code)
    _interrupted = now
    raise KeyboardInterrupt


class OutputLost(OSError): ...


class _Raw(io.RawIOBase):
    """Drops everything after a failed write, which raises `OutputLost` if `raises`."""

    def __init__(self, text: Any, raises: bool) -> None:
        # With `python -u` there is no buffer.
        self._text, self._stream = text, getattr(text.buffer, "raw", text.buffer)
        self._raises, self._lost = raises, False

    def write(self, data: "Buffer", /) -> int | None:
        if not self._lost:
            try:
                return self._stream.write(data)
            except OSError as error:
                self._lost = True
                if self._raises:
                    raise OutputLost(error.errno, error.strerror) from None
        return memoryview(data).nbytes

    def writable(self) -> bool:
        return True

    def fileno(self) -> int:
        return self._stream.fileno()

    def isatty(self) -> bool:
        return self._stream.isatty()


def _stream(before: Any, raises: bool) -> io.TextIOWrapper:
    """A standard stream that can write every text, with UTF-8 instead of ASCII. `before`: None if the shell
    has closed it.
    """
    if before is None:
        before = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115
    encoding = "utf-8" if codecs.lookup(before.encoding).name == "ascii" else before.encoding
    raw = _Raw(before, raises)
    buffer: Any = raw if before.write_through else io.BufferedWriter(raw)
    return io.TextIOWrapper(
        buffer,
        encoding,
        "duet-readable",
        line_buffering=before.line_buffering,
        write_through=before.write_through,
    )


def _readable(error: UnicodeError) -> tuple[str | bytes, int]:
    """Escape what an encoding lacks, but keep bytes of a file's name that the locale could not read."""
    try:
        return codecs.lookup_error("surrogateescape")(error)
    except UnicodeError:
        return codecs.lookup_error("backslashreplace")(error)


codecs.register_error("duet-readable", _readable)


def _fill_descriptors() -> None:
    """Open the null device for closed descriptors 0 to 2, which the next file would get."""
    while (number := os.open(os.devnull, os.O_RDWR)) <= 2:
        os.set_inheritable(number, True)
    os.close(number)


def write_log() -> None:
    """Log to stderr, with the time in a file; a service's journal adds its own."""
    time = "%(asctime)s " if stat.S_ISREG(os.fstat(2).st_mode) else ""
    logging.basicConfig(level=logging.INFO, format=f"{time}%(levelname)s %(name)s: %(message)s")
