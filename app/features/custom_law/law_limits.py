"""Time and memory limits, also for an overloaded machine."""

import sys
import time
from dataclasses import dataclass
from typing import Final, NamedTuple

from controllers.errors import LazyText


@dataclass(frozen=True)
class LawLimits:
    """Limits of a law's process.

    Attributes:
        start: until the process runs [s].
        load: for reading the file, and for the first call, which may load a library [s].
        call: for every further call [s].
        memory: in addition to Python and NumPy [bytes].
    """

    start: float = 30.0
    load: float = 3.0
    call: float = 0.05
    memory: int = 512 * 2**20


class LawProblem(NamedTuple):
    """Why a law is not in force.

    Attributes:
        text: one line: file, line, fault, expectation.
        line: 1-based.
    """

    text: str
    line: int | None = None


def problem_of(name: str, what: str, line: int | None = None) -> LawProblem:
    if line is None:
        return LawProblem(LazyText("{name}: {what}", name=name, what=what))
    return LawProblem(LazyText("{name}, line {line}: {what}", name=name, line=line, what=what), line)


LONGEST: Final = 20.0
"""Multiple of a limit that is always too long."""


class Patience:
    """A time limit [s] without the process's waits for a core, if the system can tell."""

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
    """Time that a process's first thread has waited for a core [s]; 0 if unknown."""
    try:
        with open(f"/proc/{process}/schedstat", encoding="ascii") as file:
            return int(file.read().split()[1]) * 1e-9
    except (OSError, ValueError, IndexError):
        return 0.0


def processor_time(process: int) -> float | None:
    """Of all threads [s]; None if unknown."""
    if sys.platform != "linux":
        return None
    try:
        # Linux's clock id of a process (CPUCLOCK_SCHED in its posix-timers).
        return time.clock_gettime(~process << 3 | 2)
    except OSError:
        return None


def wants_a_core(process: int) -> bool:
    try:
        with open(f"/proc/{process}/stat", encoding="ascii", errors="replace") as file:
            return file.read().rpartition(")")[2].split()[0] == "R"
    except (OSError, IndexError):
        return False


SHARE: Final = 0.4
"""Share of the wall time that the frame thread waits for all custom laws."""

_LATELY: Final = 0.5
"""Time after which an uncalled law is ignored [s]."""


class LawTimeShare:
    """Divides `SHARE` equally among the sessions that call a law."""

    def __init__(self) -> None:
        self._called: dict[int, float] = {}

    def part(self, session: int) -> float:
        now = time.monotonic()
        self._called[session] = now
        self._called = {one: when for one, when in self._called.items() if now - when < _LATELY}
        return SHARE / len(self._called)
