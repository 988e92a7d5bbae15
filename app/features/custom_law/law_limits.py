"""Limits of a custom law's process in time and memory, which do not count an overloaded machine, and the law's problems."""

import sys
import time
from dataclasses import dataclass
from typing import Final, NamedTuple

from controllers.errors import LazyText


@dataclass(frozen=True)
class LawLimits:
    """Time and memory for the process of a law.

    Attributes:
        start: time until the process is up, before it has seen the file [s]; nothing that the file could do anything about.
        load: time for reading the file, and for the first call, which may have to load a library [s].
        call: time for every further call [s].
        memory: what it may take in addition to Python and NumPy [bytes].
    """

    start: float = 30.0
    load: float = 3.0
    call: float = 0.05
    memory: int = 512 * 2**20


class LawProblem(NamedTuple):
    """Why a law is not in force.

    Attributes:
        text: one line for its author: file, line if it is known, what is wrong, what was expected.
        line: of the file, counted from 1; None if unknown.
    """

    text: str
    line: int | None = None


def problem_of(name: str, what: str, line: int | None = None) -> LawProblem:
    if line is None:
        return LawProblem(LazyText("{name}: {what}", name=name, what=what))
    return LawProblem(LazyText("{name}, line {line}: {what}", name=name, line=line, what=what), line)


LONGEST: Final = 20.0
"""Multiples of the limit after which it is too long whatever the reason."""


class Patience:
    """A time limit that does not count the time during which the other process waited for a core, where the system can tell.

    Args:
        process: id of the other process.
        limit: [s].

    Attributes:
        limit: [s].
    """

    def __init__(self, process: int, limit: float) -> None:
        self.limit = limit
        self._process = process
        self._begin = time.monotonic()
        self._used, self._without_core = processor_time(process), without_core(process)

    @property
    def over(self) -> bool:
        waited = time.monotonic() - self._begin
        if waited <= self.limit:
            return False
        used = processor_time(self._process)
        if waited > LONGEST * self.limit or self._used is None or used is None:
            return True
        if wants_a_core(self._process):
            return used - self._used > self.limit
        # It may have begun late, and sleep now.
        return waited - (without_core(self._process) - self._without_core) > self.limit


def without_core(process: int) -> float:
    """Time that the first thread of a process has waited for a core so far [s]; 0 if the system does not say."""
    try:
        with open(f"/proc/{process}/schedstat", encoding="ascii") as file:
            return int(file.read().split()[1]) * 1e-9
    except (OSError, ValueError, IndexError):
        return 0.0


def processor_time(process: int) -> float | None:
    """Processor time of a process so far, all threads [s]; None if the system does not say."""
    if sys.platform != "linux":
        return None
    try:
        # The number that Linux gives to the clock of a process (CPUCLOCK_SCHED in its posix-timers).
        return time.clock_gettime(~process << 3 | 2)
    except OSError:
        return None


def wants_a_core(process: int) -> bool:
    """True if a process runs, or would if it were given a core."""
    try:
        with open(f"/proc/{process}/stat", encoding="ascii", errors="replace") as file:
            return file.read().rpartition(")")[2].split()[0] == "R"
    except (OSError, IndexError):
        return False


SHARE: Final = 0.4
"""Part of the wall time that the frame thread waits for all custom laws together."""

_LATELY: Final = 0.5
"""Time after which a law that was not called does not count any more [s]."""


class LawTimeShare:
    """`SHARE` in equal parts, one for every session that calls a custom law."""

    def __init__(self) -> None:
        self._called: dict[int, float] = {}

    def part(self, session: int) -> float:
        """Return the part of the wall time that one session's law has. `session`: any number of its own; its law is called now."""
        now = time.monotonic()
        self._called[session] = now
        self._called = {one: when for one, when in self._called.items() if now - when < _LATELY}
        return SHARE / len(self._called)
