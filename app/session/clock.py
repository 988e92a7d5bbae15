"""Clock of a run, and reasons for a halt."""

from dataclasses import dataclass
from typing import Final, Literal

FRAME: Final = 1.0 / 32.0
"""Wall time of a frame [s]."""

BUDGET: Final = 0.02
"""Wall time for one session's steps in one frame [s]; beyond it simulated time slows down."""

TOGETHER: Final = 2
"""Number of sessions with the whole budget; more sessions share their total."""

SLOWEST: Final = 1.0 / 22.0
"""Longest frame that steps may cause [s]; simulated time slows down first."""

LEAST: Final = 0.01
"""Wall time for all sessions' steps in a frame, however slow drawing is [s]."""

LONGEST_GAP: Final = 0.1
"""Longest pause of the program that is caught up [s]."""

SLOW, OVER = 0.5, 0.15
"""Shares of late frames in the last second: a run is slowed above the first, until below the second."""

SPEEDS: Final = (0.25, 0.5, 1.0, 2.0)


@dataclass(frozen=True)
class Pace:
    """State of the clock.

    Attributes:
        rate: simulated over wall time, over half a second.
        slowed: the machine cannot keep up with the chosen speed.
    """

    paused: bool
    rate: float
    slowed: bool


def budget_of(sessions: int, drawing: float = 0.0) -> float:
    """Wall time for each session's steps in a frame [s]. `drawing`: wall time of everything else, for all
    sessions [s]."""
    together = min(max(SLOWEST - drawing, LEAST), BUDGET * TOGETHER)
    return together / max(sessions, TOGETHER)


def next_speed(speed: float, by: int) -> float:
    """Next slower (−1) or faster (+1) speed; at the end of the list the same."""
    nearest = min(range(len(SPEEDS)), key=lambda i: abs(SPEEDS[i] - speed))
    return SPEEDS[min(max(nearest + by, 0), len(SPEEDS) - 1)]


class Clock:
    def __init__(self, speed: float) -> None:
        self._debt = 0.0
        self._rate = speed
        self._slowness, self._slowed = 0.0, False

    def forget(self) -> None:
        self._debt = 0.0

    def due(self, elapsed: float, dt: float, speed: float) -> int:
        """Number of steps of `dt` [s] due after `elapsed` [s] of wall time."""
        self._debt += min(elapsed, LONGEST_GAP) * speed
        return int(self._debt / dt + 1e-9)

    def note(self, made: int, due: int, elapsed: float, dt: float) -> None:
        """Missed steps are not caught up."""
        late = made < due or elapsed > LONGEST_GAP
        self._debt = 0.0 if late else self._debt - made * dt
        if elapsed > 0.0:
            self._rate += (made * dt / elapsed - self._rate) * min(elapsed / 0.5, 1.0)
            self._slowness += ((1.0 if late else 0.0) - self._slowness) * min(elapsed / 1.0, 1.0)
            # Shown at once and until it is clearly over: a text that flickers cannot be read.
            self._slowed = self._slowness > (OVER if self._slowed else SLOW)

    def pace(self, paused: bool) -> Pace:
        return Pace(paused, 0.0 if paused else self._rate, self._slowed and not paused)


Reason = Literal["visitor", "lesson", "replay", "class", "teacher", "hidden"]
"""Reason for a halt. "visitor": paused; "lesson": waits for Run or is over; "replay": one is shown;
"class": the teacher pauses the shared session; "teacher": the teacher pauses the visitor's own; "hidden":
the tab is out of sight."""

NOT_THE_VISITORS: Final[frozenset[Reason]] = frozenset(("teacher", "hidden"))


class Halt(set[Reason]):
    def set(self, reason: Reason, halted: bool = True) -> None:
        if halted:
            self.add(reason)
        else:
            self.discard(reason)

    def go_on(self) -> None:
        self.intersection_update(NOT_THE_VISITORS)
