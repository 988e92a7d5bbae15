"""What goes over the line between the page's process and the law's: plain bytes, because a call must not cost more than a tick can bear.

A message is its length and a body. The body of a question begins with what is asked, that of an answer with how it went.
"""

import json
import math
import socket
import string
import struct
from enum import IntEnum
from typing import Any, Final

import numpy as np

from app.custom_law.student_situation import Array, Situation
from controllers.errors import LazyText

_LENGTH: Final = struct.Struct("<I")
_QUESTION: Final = struct.Struct("<BBHHH")
"""Question, what is there, n, m, pairs."""
_ANSWER: Final = struct.Struct("<Bd")
"""Outcome, time that the student's function took [s]."""
_FAILURE: Final = struct.Struct("<i")
"""Line, −1 if unknown; the text follows."""
_TWO: Final = struct.Struct("<2d")
_FIELDS: Final = string.Formatter().parse
_CHUNK: Final = 65536

BROKEN: Final = 76
"""Exit code of the law's process when the line does not work any more (EX_PROTOCOL)."""

_TASK, _BOUNDS, _PAIRS, _APPROACHES = 1, 2, 4, 8


class QuestionKind(IntEnum):
    """What is asked."""

    LOAD = 0
    """Here is the file."""
    LAW = 1
    """q̇ in a situation."""
    ACTIVATION = 2
    """λ at a distance."""
    RATES = 3
    """J_d q̇ of one pair at many distances."""
    ACTIVATIONS = 4
    """λ at many distances, for a chart."""


class ReplyKind(IntEnum):
    """How it went."""

    UP = 0
    """The process is there."""
    DONE = 1
    FAILED = 2
    """The payload says why, and where."""


class LawConnection:
    """One end of the line.

    Args:
        end: of a pair of stream sockets.
    """

    def __init__(self, end: socket.socket) -> None:
        self._socket = end
        self._received = b""
        self._patience: float | None = None
        end.settimeout(None)

    def send(self, body: bytes) -> None:
        """Send a message.

        Raises:
            OSError: nobody is at the other end.
        """
        self._socket.sendall(_LENGTH.pack(len(body)) + body)

    def receive(self, seconds: float | None) -> bytes | None:
        """Return the next message, or None if it is not there after a time [s]; None waits for ever.

        Raises:
            OSError, EOFError: nobody is at the other end.
        """
        if seconds != self._patience:
            self._socket.settimeout(seconds)
            self._patience = seconds
        while True:
            received = self._received
            if len(received) >= 4:
                end = 4 + _LENGTH.unpack_from(received)[0]
                if len(received) >= end:
                    self._received = received[end:]
                    return received[4:end]
            try:
                chunk = self._socket.recv(_CHUNK)
            except (TimeoutError, BlockingIOError):
                return None
            if not chunk:
                raise EOFError
            self._received = received + chunk if received else chunk

    def close(self) -> None:
        """Hang up."""
        self._socket.close()


def pack_situation(situation: tuple[Any, ...]) -> bytes:
    """Return the question for q̇. Takes every tuple with the fields of a `Situation`, with arrays of float64."""
    q, nominal, row, distance, approach, J, lower, upper, rows, distances, approaches = situation
    there = 0
    parts = [b"", q.tobytes(), nominal.tobytes(), row.tobytes(), _TWO.pack(distance, approach)]
    if J is not None:
        there |= _TASK
        parts.append(J.tobytes())
    if lower is not None and upper is not None:
        there |= _BOUNDS
        parts += (lower.tobytes(), upper.tobytes())
    if rows is not None and distances is not None:
        there |= _PAIRS
        parts += (rows.tobytes(), distances.tobytes())
        if approaches is not None:
            there |= _APPROACHES
            parts.append(approaches.tobytes())
    m, pairs = 0 if J is None else len(J), 0 if rows is None else len(rows)
    parts[0] = _QUESTION.pack(QuestionKind.LAW, there, len(row), m, pairs)
    return b"".join(parts)


def unpack_situation(body: bytes) -> Situation:
    """Return the situation that is asked about, in arrays of its own."""
    _, there, n, m, pairs = _QUESTION.unpack_from(body)
    # One copy for all: aligned, and the law may write to it.
    numbers = np.array(np.frombuffer(body, np.float64, offset=_QUESTION.size))
    distance, approach = numbers[3 * n : 3 * n + 2].tolist()
    J = lower = upper = rows = distances = approaches = None
    at = 3 * n + 2
    if there & _TASK:
        J = numbers[at : at + m * n].reshape(m, n)
        at += m * n
    if there & _BOUNDS:
        lower, upper = numbers[at : at + n], numbers[at + n : at + 2 * n]
        at += 2 * n
    if there & _PAIRS:
        rows = numbers[at : at + pairs * n].reshape(pairs, n)
        at += pairs * n
        distances = numbers[at : at + pairs]
        at += pairs
        if there & _APPROACHES:
            approaches = numbers[at : at + pairs]
    return Situation(
        *(numbers[:n], numbers[n : 2 * n], numbers[2 * n : 3 * n], distance, approach, J, lower, upper),
        *(rows, distances, approaches),
    )


def pack_file(text: bytes) -> bytes:
    """Return the question that carries the file."""
    return bytes((QuestionKind.LOAD,)) + text


def pack_activation(distance: float) -> bytes:
    """Return the question for λ."""
    return struct.pack("<Bd", QuestionKind.ACTIVATION, distance)


def unpack_activation(body: bytes) -> float:
    """Return the distance that is asked about [m]."""
    return struct.unpack("<Bd", body)[1]


def pack_activations(distances: Array) -> bytes:
    """Return the question for λ at many distances (k,)."""
    return bytes((QuestionKind.ACTIVATIONS,)) + distances.tobytes()


def unpack_activations(body: bytes) -> Array:
    """Return the distances (k,) that are asked about [m]."""
    return np.array(np.frombuffer(body, np.float64, offset=1))


def pack_rates(distances: Array, pull: float, approach: float, square: float) -> bytes:
    """Return the question for J_d q̇ at many distances (k,)."""
    return struct.pack("<B3d", QuestionKind.RATES, pull, approach, square) + distances.tobytes()


def unpack_rates(body: bytes) -> tuple[Array, float, float, float]:
    """Return what `pack_rates` was given."""
    _, pull, approach, square = struct.unpack_from("<B3d", body)
    return np.array(np.frombuffer(body, np.float64, offset=struct.calcsize("<B3d"))), pull, approach, square


def pack_answer(outcome: ReplyKind, payload: bytes = b"", seconds: float = math.nan) -> bytes:
    """Return an answer."""
    return _ANSWER.pack(outcome, seconds) + payload


def unpack_answer(body: bytes) -> tuple[ReplyKind, bytes, float]:
    """Return outcome, payload and time taken [s].

    Raises:
        ValueError, struct.error: this is no answer; the law has written to the line itself.
    """
    outcome, seconds = _ANSWER.unpack_from(body)
    return ReplyKind(outcome), body[_ANSWER.size :], seconds


def pack_failure(text: str, line: int | None) -> bytes:
    """Return the payload of a failed answer."""
    told = json.dumps(_told(text), ensure_ascii=False)
    return _FAILURE.pack(-1 if line is None else line) + told.encode(errors="replace")


def unpack_failure(payload: bytes) -> tuple[str, int | None]:
    """Return what is wrong, and the line.

    Raises:
        ValueError: the payload is not of `pack_failure`.
    """
    (line,) = _FAILURE.unpack_from(payload)
    try:
        told = json.loads(payload[_FAILURE.size :].decode(errors="replace"))
    except RecursionError:
        raise ValueError("is too deep") from None
    return _message(told), None if line < 0 else line


def _told(text: object) -> object:
    """Return a text as plain data, a `LazyText` as its template and parts."""
    if isinstance(text, LazyText):
        return [_told(text.template), {name: _told(part) for name, part in text.parts.items()}]
    return str(text)


def _clean(text: str) -> str:
    """Return a text without halves of characters, which no page can be sent."""
    return text.encode(errors="replace").decode()


def _message(told: Any) -> str:
    """Return the text of plain data: whatever a law may write to the line, nothing but text is filled in."""
    if isinstance(told, str):
        return _clean(told)
    if not (isinstance(told, list) and len(told) == 2 and isinstance(told[0], str) and isinstance(told[1], dict)):
        raise ValueError("is no message")
    template, parts = _clean(told[0]), told[1]
    try:
        if parts and not all(f is None or (f in parts and not form and not how) for _, f, form, how in _FIELDS(template)):
            raise ValueError("is no template")
        return LazyText(template, **{name: _message(part) for name, part in parts.items()})
    except (LookupError, TypeError):
        raise ValueError("is no template") from None
