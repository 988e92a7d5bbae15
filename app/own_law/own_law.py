"""A law that stands in a file of one's own."""

import errno
import struct
from pathlib import Path
from time import monotonic
from types import TracebackType
from typing import ClassVar, Final

import numpy as np

from app.own_law.limits import Limits, Problem, problem_of
from app.own_law.process import LawFailed, LawProcess
from app.own_law.wire import pack_activation, pack_rates, pack_situation
from controllers.errors import BadInputFile, Message
from controllers.kinematics import Array
from controllers.laws.situation import Situation
from scenes.files import read_file, readable

LOOK: Final = 0.5
"""Time between two looks at the file [s]."""

LARGEST: Final = 2**20
"""Size of a file [bytes]; more is none that somebody wrote."""

_MISSED: Final = 4
"""Looks in a row without a file, after which it is away."""

_REMEMBERED: Final = 4096
"""Values of λ kept: a curve is drawn again and again at the same distances."""


class OwnLaw:
    """A law (see `controllers.laws.situation.Law`) that calls `law(situation)` of a file, in a process of its own.

    The process is started by the first call, and anew when the file has changed; there is never more than one. Where the law
    fails, q̇ = 0: the arm freezes, and `problem` says why. It stays so until the file has changed, or `restart`. An exception never
    leaves any method. All methods belong to one thread; one `OwnLaw` may be the law of several simulations of that thread.

    The same situations give the same bits as long as the law itself keeps nothing in mind between two calls.

    Args:
        path: of the file.
        limits: of time and memory.
        waits: whether a call waits until the file is loaded. If not, nobody is ever held up by more than two calls' limit (on a busy
            machine, by the time in which the law gets as much of a core), and the arm stands still until then.
        text: of the file, if it is known already; None to read it.

    Attributes:
        problem: why it is not in force; None if all is well. After the file has changed, the old one's stays until the new one has
            given velocities; `refresh` asks it for some, so that it goes while nothing moves, too.

    Raises:
        BadInputFile: there is no such file, or it cannot be read.
    """

    wants_task: ClassVar[bool] = True
    wants_all_pairs: ClassVar[bool] = True
    """A file that says `WANTS_ALL_PAIRS = False` is spared them."""

    def __init__(
        self,
        path: Path,
        limits: Limits = Limits(),  # noqa: B008 (frozen)
        waits: bool = False,
        text: bytes | None = None,
    ) -> None:
        self.path = path.absolute()
        self.limits = limits
        self.problem: Problem | None = None
        self._waits = waits
        self._process: LawProcess | None = None
        self._stamp = _stamp(self.path)
        self._text = read_law(self.path) if text is None else text
        self._looked = monotonic()
        self._idle = False
        """Whether no process is to be started: the law has failed, or is closed."""
        self._closed = False
        self._known: dict[float, float] = {}
        self._question: bytes | None = None
        """The newest situation, as it was asked about."""
        self._answered = False
        """Whether the present process has given velocities."""
        self._missed = 0

    def __enter__(self) -> "OwnLaw":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    @property
    def pid(self) -> int | None:
        """Id of the process; None while there is none."""
        return self._process.pid if self._process is not None else None

    @property
    def away(self) -> bool:
        """Whether the file has not been there for a while; what was read of it last stays in force."""
        return self._missed >= _MISSED

    @property
    def seconds(self) -> float:
        """Time that the newest call took inside the law, without the way there and back [s]; nan if there was none."""
        return self._process.seconds if self._process is not None else float("nan")

    @property
    def ready(self) -> bool:
        """Whether the file is loaded and has not failed; nothing is loaded before the first call or `restart`."""
        return self._process is not None and self._ready(False) is not None

    def __call__(self, situation: Situation) -> Array:
        """Return q̇ (n,) [rad/s]; zeros where the law does not give any."""
        self._question = pack_situation(situation)
        payload = self._ask(self._question)
        if payload is None:
            return np.zeros(len(situation.nominal))
        velocities = np.frombuffer(payload, np.float64).copy()
        self._answered, self.problem = True, None
        return velocities

    def activation(self, distance: float) -> float:
        """Return what the file's `activation(distance)` says, in [0, 1]; 0 if it has none, or has failed."""
        if not self._has_activation():
            return 0.0
        known = self._known.get(distance)
        if known is not None:
            return known
        payload = self._ask(pack_activation(distance))
        if payload is None:
            return 0.0
        if len(self._known) >= _REMEMBERED:
            self._known.clear()
        lam: float = struct.unpack("<d", payload)[0]
        self._known[distance] = lam
        return lam

    def line_rate(self, distance: float, pull: float, approach: float, square: float) -> float:
        """Return J_d q̇ [m/s] of an arm of which only one joint moves the distance, see `Law.line_rate`; nan where the law fails."""
        return float(self.line_rates(np.array([distance]), pull, approach, square)[0])

    def line_rates(self, distances: Array, pull: float, approach: float, square: float) -> Array:
        """Return `line_rate` (k,) at many distances (k,) at once, which costs one way there and back instead of k."""
        payload = self._ask(pack_rates(distances, pull, approach, square))
        return np.full(len(distances), np.nan) if payload is None else np.frombuffer(payload, np.float64).copy()

    def refresh(self) -> bool:
        """Return whether the file has changed, and if so load it. It looks no more often than every 0.5 s, so call it every frame."""
        now = monotonic()
        if self._closed:
            return False
        if self._process is not None:
            # So that a file that has been broken, or mended, is noticed while nothing moves.
            self._try()
        if now - self._looked < LOOK:
            return False
        self._looked = now
        stamp = _stamp(self.path)
        self._missed = self._missed + 1 if stamp is None else 0
        if stamp is None or stamp == self._stamp:
            # Editors replace a file by removing it first: that it is away is no news.
            return False
        self._stamp = stamp
        try:
            text = read_law(self.path)
        except BadInputFile as error:
            self._fail(Problem(str(error)))
            return True
        if text == self._text and self.problem is None:
            return False
        self._text = text
        if self._process is not None or self._idle:
            self.restart()
        return True

    def _try(self) -> None:
        """Look whether a process that has not given any velocities yet is loaded, and does so in the newest situation."""
        if self._answered or self._ready(False) is None:
            return
        if self._question is None:
            self.problem = None
        elif self._ask(self._question) is not None:
            self._answered, self.problem = True, None

    def load(self) -> bool:
        """Return whether the file could be loaded; waits for it, whatever `waits` is."""
        return self._ready(True) is not None

    def restart(self) -> None:
        """Begin anew with the text as it is, at once; after a failure that was the machine's."""
        if self._closed:
            return
        self._end()
        self._idle = False
        self._ready(False)

    def close(self) -> None:
        """End the process; from now on q̇ = 0."""
        self._end()
        self._closed = self._idle = True

    def _ready(self, wait: bool) -> LawProcess | None:
        """Return the process if it can be asked; start it if there is none and there may be one."""
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
                problem_of(readable(self.path.name), Message("its process could not be started: {error}", error=str(error)))
            )
            return None
        # The file, not the class, has the last word.
        self.__dict__["wants_all_pairs"] = self._process.wants_all_pairs
        return self._process

    def _has_activation(self) -> bool:
        process = self._ready(self._waits)
        return process is not None and process.has_activation

    def _ask(self, question: bytes) -> bytes | None:
        process = self._ready(self._waits)
        if process is None:
            return None
        try:
            return process.ask(question, self._waits)
        except LawFailed as failed:
            self._fail(failed.problem)
            return None

    def _fail(self, problem: Problem) -> None:
        self.problem = problem
        self._end()
        self._idle = True

    def _end(self) -> None:
        self._known.clear()
        self._answered = False
        process, self._process = self._process, None
        if process is not None:
            process.end()


def _stamp(path: Path) -> tuple[int, int, int] | None:
    """Return what changes when a file is written; None if it is not there."""
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size, found.st_ino


def read_law(path: Path) -> bytes:
    """Return a law's file as it is.

    Raises:
        BadInputFile: see there.
    """
    try:
        return read_file(path, LARGEST)
    except FileNotFoundError:
        raise BadInputFile(
            "{path}: there is no such file; `lwr-duet new-law {name}` writes one to begin with.", path=path, name=path.name
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
