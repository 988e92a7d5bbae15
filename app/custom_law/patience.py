"""Time limits that tell an endless loop from an overloaded machine."""

import sys
import time
from typing import Final

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
        self._used = _used(process)

    @property
    def over(self) -> bool:
        waited = time.monotonic() - self._begin
        if waited <= self.limit:
            return False
        if waited > LONGEST * self.limit or self._used is None or not _wants_a_core(self._process):
            return True
        used = _used(self._process)
        return used is None or used - self._used > self.limit


def _used(process: int) -> float | None:
    """Return the processor time of a process so far [s]; None if the system does not say."""
    if sys.platform != "linux":
        return None
    try:
        # The number that Linux gives to the clock of a process (CPUCLOCK_SCHED in its posix-timers).
        return time.clock_gettime(~process << 3 | 2)
    except OSError:
        return None


def _wants_a_core(process: int) -> bool:
    """Return whether a process runs, or would if it were given a core."""
    try:
        with open(f"/proc/{process}/stat", encoding="ascii", errors="replace") as file:
            return file.read().rpartition(")")[2].split()[0] == "R"
    except (OSError, IndexError):
        return False
