"""A law in a file."""

import errno
import hashlib
import math
from pathlib import Path
from time import monotonic
from typing import ClassVar, Final, Self

import numpy as np

from app.features.custom_law.law_limits import LawLimits, LawProblem, problem_of
from app.features.custom_law.process import LawFailed, LawProcess
from app.features.custom_law.wire import (
    ActivationQuestion,
    ActivationsQuestion,
    LawQuestion,
    RatesQuestion,
    VelocityQuestion,
)
from controllers.errors import BadInputFile, LazyText
from controllers.kinematics import Array
from controllers.laws.situation import Situation, Unanswered
from scenes.files import read_file, readable
from scenes.law_answers import LawOfFile

LOOK: Final = 0.5
"""Period of the check for a changed file [s]."""

LARGEST: Final = 2**20
"""Largest file [bytes]."""

MOST: Final = 0.0125
"""Longest wait for a frame's calls [s]."""

LONG: Final = 0.1
"""Wait after which the page reports a call [s]."""

_MISSED: Final = 4
"""Consecutive checks without the file, until it is away."""


class CustomLaw(LawOfFile):
    """A law that calls `law(situation)` of a file in its own process.

    The first call starts the process, and a changed file restarts it. Where the law fails, q̇ = 0 until the
    file changes or `restart`. All methods belong to one thread. They raise no exception of the law, only
    `Unanswered` while an answer is pending. A law without state gives the same bits for the same situations.

    Args:
        waits: if true, a call waits for its answer up to the limits. If false, only as long as `allow` grants
            in total; repeating an unanswered call does not ask again.

    Attributes:
        problem: reason of the failure. It stays until a changed file has given velocities.
        sha256: hexadecimal, of the file as last read.
        need: mean time of about ten calls inside the law [s]; 0 before the first.

    Raises:
        BadInputFile: the file cannot be read.
    """

    wants_task: ClassVar[bool] = True
    wants_all_pairs: ClassVar[bool] = True

    def __init__(
        self,
        path: Path,
        limits: LawLimits = LawLimits(),  # noqa: B008 (frozen)
        waits: bool = False,
        text: bytes | None = None,
    ) -> None:
        self.path, self.file = path.absolute(), readable(path.name)
        self.limits = limits
        self.problem: LawProblem | None = None
        self.need = 0.0
        self._waits = waits
        self._process: LawProcess | None = None
        self._stamp = _stamp(self.path)
        self._text = read_law(self.path) if text is None else text
        self.sha256 = hashlib.sha256(self._text).hexdigest()
        self._looked = monotonic()
        self._idle = False
        """True if no process may start: it failed or is closed."""
        self._closed = False
        self._lam: tuple[float, float] | None = None
        """Last distance and its λ: at rest they repeat."""
        self._question: VelocityQuestion | None = None
        self._answers: dict[LawQuestion, Array] = {}
        self._curves: dict[type[LawQuestion], tuple[LawQuestion, Array]] = {}
        self._left = 0.0
        """Remaining waiting time [s]."""
        self._since: float | None = None
        self._missed = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *raised: object) -> None:
        self.close()

    @property
    def pid(self) -> int | None:
        return self._process.pid if self._process is not None else None

    @property
    def away(self) -> bool:
        """True if the file is missing for a while; its last content stays in force."""
        return self._missed >= _MISSED

    @property
    def seconds(self) -> float:
        """Time of the last call inside the law [s]; nan before the first."""
        return self._process.seconds if self._process is not None else float("nan")

    @property
    def ready(self) -> bool:
        return self._process is not None and self._ready(False) is not None

    @property
    def waiting(self) -> bool:
        return self._since is not None and monotonic() - self._since > LONG

    def allow(self, seconds: float) -> None:
        """Add waiting time [s], up to `MOST`."""
        self._left = min(self._left + seconds, MOST)

    def step_made(self) -> int:
        """Clear the step's answers; return its number of calls."""
        calls = sum(isinstance(question, VelocityQuestion) for question in self._answers)
        self._answers.clear()
        return calls

    def __call__(self, situation: Situation) -> Array:
        self._question = VelocityQuestion.of(situation)
        velocities = self._ask(self._question)
        return np.zeros(len(situation.nominal)) if velocities is None else velocities.copy()

    def activation(self, distance: float) -> float:
        """λ in [0, 1]; 0 if the file gives none, or failed."""
        if self._lam is not None and self._lam[0] == distance:
            return self._lam[1]
        process = self._loaded()
        if process is None or not process.has_activation:
            return 0.0
        values = self._ask(ActivationQuestion(distance))
        if values is None:
            return 0.0
        self._lam = distance, float(values[0])
        return self._lam[1]

    def activations(self, distances: Array) -> Array:
        """Last λ (k,) at distances (k,); nan until known."""
        process = self._ready(self._waits)
        if process is not None and not process.has_activation:
            return np.zeros(len(distances))
        return self._curve(ActivationsQuestion(distances.tobytes()), len(distances))

    def line_rates(self, distances: Array, pull: float, approach: float, square: float) -> Array:
        """Last `line_rate` (k,) at distances (k,); nan until known."""
        return self._curve(RatesQuestion(distances.tobytes(), pull, approach, square), len(distances))

    def refresh(self) -> bool:
        """Load a changed file; true if so. For every frame: it looks at most every 0.5 s."""
        now = monotonic()
        if self._closed:
            return False
        if self._process is not None:
            # So that a broken or repaired file is noticed at rest.
            self._listen()
        if now - self._looked < LOOK:
            return False
        self._looked = now
        stamp = _stamp(self.path)
        self._missed = self._missed + 1 if stamp is None else 0
        if stamp is None or stamp == self._stamp:
            # Editors replace a file by removing it first: a missing file is normal for a moment.
            return False
        self._stamp = stamp
        try:
            text = read_law(self.path)
        except BadInputFile as error:
            self._fail(LawProblem(str(error)))
            return True
        if text == self._text and self.problem is None:
            return False
        self._text = text
        self.sha256 = hashlib.sha256(text).hexdigest()
        if self._process is not None or self._idle:
            self.restart()
        return True

    def _listen(self) -> None:
        process = self._ready(False)
        if process is None:
            return
        if math.isnan(process.seconds):
            if self._question is None:
                self.problem = None
            elif not process.asked(VelocityQuestion):
                self._post(process, self._question)
        while self._take_in(process, 0.0):
            pass
        if not process.busy:
            self._since = None

    def load(self) -> bool:
        """Wait for the file; true if it could be loaded."""
        return self._ready(True) is not None

    def restart(self) -> None:
        """Restart after a failure that the machine caused."""
        if self._closed:
            return
        self._end()
        self._idle = False
        self._ready(False)

    def close(self) -> None:
        """q̇ = 0 from now on."""
        self._end()
        self._closed = self._idle = True

    def _ready(self, wait: bool) -> LawProcess | None:
        if self._idle:
            return None
        try:
            if self._process is None:
                self._process = LawProcess(self.path, self._text, self.limits)
            if not self._process.ready(wait):
                return None
        except LawFailed as failed:
            self._fail(failed.problem)
            return None
        except OSError as error:
            self._fail(
                problem_of(self.file, LazyText("its process could not be started: {error}", error=str(error)))
            )
            return None
        # The file decides, not the class.
        self.__dict__["wants_all_pairs"] = self._process.wants_all_pairs
        return self._process

    def _loaded(self) -> LawProcess | None:
        process = self._ready(self._waits)
        if process is None and not self._idle:
            raise self._unanswered()
        return process

    def _ask(self, question: LawQuestion) -> Array | None:
        while (process := self._loaded()) is not None:
            if question in self._answers:
                # With `waits` no step is repeated, and a law may answer a repeated question differently.
                return self._answers.pop(question) if self._waits else self._answers[question]
            kind = type(question)
            # Do not wait for a law that was slower last time, or did not answer in an earlier frame.
            in_vain = process.asked(kind) or (kind is VelocityQuestion and process.seconds > self._left)
            if not process.asked(kind):
                self._post(process, question)
            begin = monotonic()
            there = self._take_in(process, math.inf if self._waits else 0.0 if in_vain else self._left)
            self._left = max(self._left - (monotonic() - begin), 0.0)
            if not there and not self._idle:
                raise self._unanswered()
        return None

    def _unanswered(self) -> Unanswered:
        self._since = self._since or monotonic()
        return Unanswered()

    def _curve(self, question: LawQuestion, count: int) -> Array:
        """Last curve (count,), nan until known; a new question is asked."""
        process, kind = self._ready(self._waits), type(question)
        if process is not None and self._curves.get(kind, (None,))[0] != question and not process.asked(kind):
            self._post(process, question)
            while self._take_in(process, math.inf if self._waits else 0.0):
                pass
        values = self._curves[kind][1] if kind in self._curves else ()
        return np.array(values) if len(values) == count else np.full(count, np.nan)

    def _post(self, process: LawProcess, question: LawQuestion) -> None:
        try:
            process.ask(question)
        except LawFailed as failed:
            self._fail(failed.problem)

    def _take_in(self, process: LawProcess, seconds: float) -> bool:
        try:
            news = process.answer(seconds) if process is self._process else None
        except LawFailed as failed:
            self._fail(failed.problem)
            return False
        if news is None:
            return False
        question, values = news[0], news[1].array()
        if isinstance(question, RatesQuestion | ActivationsQuestion):
            self._curves[type(question)] = question, values
            return True
        self._answers[question] = values
        if isinstance(question, VelocityQuestion):
            self.problem = None
            self.need += (process.seconds - self.need) * (0.1 if self.need else 1.0)
        return True

    def _fail(self, problem: LawProblem) -> None:
        self.problem = problem
        self._end()
        self._idle = True

    def _end(self) -> None:
        self._answers.clear()
        self._curves.clear()
        self._lam, self._since, self.need = None, None, 0.0
        process, self._process = self._process, None
        if process is not None:
            process.end()


def _stamp(path: Path) -> tuple[int, int, int] | None:
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size, found.st_ino


def read_law(path: Path) -> bytes:
    """Content of a law's file.

    Raises:
        BadInputFile: it cannot be read, or is too large.
    """
    try:
        return read_file(path, LARGEST)
    except FileNotFoundError:
        raise BadInputFile(
            "{path}: there is no such file; `lwr-duet new-law {name}` writes one to begin with.",
            path=path,
            name=path.name,
        ) from None
    except OSError as error:
        if error.errno == errno.EFBIG:
            raise BadInputFile(
                "{path}: is larger than {size} MiB; give a Python file with a function law(situation).",
                path=path,
                size=LARGEST >> 20,
            ) from None
        raise BadInputFile(
            "{path}: cannot be read ({reason}); give a Python file with a function law(situation).",
            path=path,
            reason=error.strerror,
        ) from None
