"""The page's side of a student's law: load the file, ask, and say what went wrong."""

import contextlib
import math
import signal
import struct
from collections import deque
from pathlib import Path
from time import monotonic
from typing import Final, Literal

from app.custom_law.child import Child
from app.custom_law.law_file import quoted
from app.custom_law.law_limits import LawLimits, LawProblem, problem_of
from app.custom_law.patience import Patience
from app.custom_law.wire import BROKEN, QuestionKind, ReplyKind, pack_file, unpack_answer, unpack_failure
from controllers.errors import LazyText, joined
from scenes.files import readable

_SLICE: Final = 0.02
"""How often somebody who waits looks whether it is too long [s]."""


class LawFailed(Exception):
    """The law failed; its process is gone.

    Args:
        problem: why.
    """

    def __init__(self, problem: LawProblem) -> None:
        super().__init__(problem.text)
        self.problem = problem


class LawProcess:
    """A process with one version of a file.

    Args:
        path: of the file.
        text: of it, as it is.
        limits: that it is held to.

    Attributes:
        wants_all_pairs, has_activation: what the file says, once it is ready.
        seconds: time that the newest call of the law took by itself, without the way to it [s].
    """

    def __init__(self, path: Path, text: bytes, limits: LawLimits) -> None:
        self.wants_all_pairs, self.has_activation = True, False
        self.seconds = float("nan")
        self._name, self._text, self._limits = readable(path.name), text, limits
        self._child = Child(path, limits.memory)
        self._phase: Literal["starting", "loading", "ready"] = "starting"
        self._patience = Patience(self.pid, limits.start)
        self._asked: deque[bytes] = deque()
        self._first = set(QuestionKind)

    @property
    def pid(self) -> int:
        """Id of the process."""
        return self._child.pid

    def end(self) -> None:
        """End it, if that has not been done yet."""
        self._child.end()

    def ready(self, wait: bool) -> bool:
        """Return whether it can be asked.

        Args:
            wait: until it can.

        Raises:
            LawFailed: the file cannot be used.
        """
        while self._phase != "ready":
            payload = self._receive(math.inf if wait else 0.0)
            if payload is None:
                return False
            if self._phase == "starting":
                self._phase = "loading"
                self._patience = Patience(self.pid, self._limits.load)
                self._send(pack_file(self._text))
            else:
                self._phase = "ready"
                self.wants_all_pairs, self.has_activation = map(bool, payload)
        return True

    @property
    def busy(self) -> bool:
        """Whether any question waits for its answer."""
        return bool(self._asked)

    def asked(self, kind: QuestionKind) -> bool:
        """Return whether a question of a kind waits for its answer."""
        return any(question[0] == kind for question in self._asked)

    def ask(self, question: bytes) -> None:
        """Ask a question of `app.custom_law.wire`; only once it is ready.

        Raises:
            LawFailed: the process is gone.
        """
        self._send(question)
        self._asked.append(question)
        if len(self._asked) == 1:
            self._be_patient()

    def answer(self, seconds: float) -> tuple[bytes, bytes] | None:
        """Return the question that was asked first, and the payload of its answer; None if that is not there in time.

        Args:
            seconds: how long to wait, at most until the law has had its time [s].

        Raises:
            LawFailed: an exception, a result that is none, no answer in time, or the process is gone.
        """
        payload = self._receive(seconds) if self._asked else None
        if payload is None:
            return None
        question = self._asked.popleft()
        if self._asked:
            self._be_patient()
        return question, payload

    def _be_patient(self) -> None:
        """Give the question that is answered next its time; the first of its kind may have to load a library."""
        kind = QuestionKind(self._asked[0][0])
        self._patience = Patience(self.pid, self._limits.load if kind in self._first else self._limits.call)
        self._first.discard(kind)

    def _receive(self, seconds: float) -> bytes | None:
        """Return the payload of the next answer; None if it is not there in time."""
        end = monotonic() + seconds
        while True:
            left = max(end - monotonic(), 0.0)
            body = self._body(min(left, _SLICE))
            if body is None and self._patience.over:
                # It may have come while the clocks were read.
                body = self._body(0.0)
                if body is None:
                    raise self._too_long(self._patience.limit)
            if body is not None:
                return self._payload(body)
            if left <= _SLICE:
                return None

    def _payload(self, body: bytes) -> bytes:
        try:
            outcome, payload, seconds = unpack_answer(body)
            if outcome is not ReplyKind.FAILED:
                if not math.isnan(seconds):
                    self.seconds = seconds
                return payload
            text, line = unpack_failure(payload)
        except (ValueError, struct.error):
            line = None
            text = LazyText("it wrote to the line between its process and the page; descriptors are not its own")
        raise self._lost(text, line)

    def _send(self, body: bytes) -> None:
        try:
            self._child.line.send(body)
        except OSError:
            raise self._died() from None

    def _body(self, seconds: float) -> bytes | None:
        try:
            return self._child.line.receive(seconds)
        except (OSError, EOFError):
            raise self._died() from None

    def _lost(self, what: str, line: int | None = None) -> LawFailed:
        """Return the failure, after an end to everything."""
        self.end()
        return LawFailed(problem_of(self._name, what, line))

    def _too_long(self, limit: float) -> LawFailed:
        if self._phase == "starting":
            return self._lost(
                LazyText(
                    "its process was not up within {limit:g} s; is the computer overloaded? Save the file to try again",
                    limit=limit,
                )
            )
        line = self._child.place()
        told = {"limit": limit * 1e3, "where": quoted(self._text, line)}
        if self._phase == "loading":
            what = LazyText("reading the file did not end within {limit:g} ms{where}. Is there an endless loop?", **told)
        else:
            what = LazyText("no answer within {limit:g} ms{where}. Is there an endless loop?", **told)
        return self._lost(what, line)

    def _died(self) -> LawFailed:
        """Return why nobody is at the other end of the line."""
        code, words, line = self._child.last_words()
        if self._phase == "starting":
            why = words.splitlines()[-1] if words else LazyText("exit code {code}", code=code)
            return self._lost(LazyText("its process could not be started: {error}", error=why))
        if code is None or code == BROKEN:
            what = LazyText("it hung up the line between its process and the page; descriptors are not its own")
        elif code >= 0:
            what = LazyText(
                "it ended its own process (exit code {code}); a law returns velocities, or raises an exception", code=code
            )
        elif -code == getattr(signal, "SIGKILL", None):
            what = LazyText("its process was ended from outside; perhaps the computer had no memory left")
        else:
            what = LazyText("its process crashed ({signal})", signal=_signal_name(-code))
        return self._lost(joined((what, quoted(self._text, line)), ""), line)


def _signal_name(number: int) -> str:
    with contextlib.suppress(ValueError):
        return signal.Signals(number).name
    return f"signal {number}"
