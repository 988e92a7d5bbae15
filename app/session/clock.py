"""A run's clock: how many steps are due in a frame, how fast simulated time has gone lately, and why the run stands still."""

from dataclasses import dataclass
from typing import Final, Literal

FRAME: Final = 1.0 / 32.0
"""Wall time of a frame [s]."""

BUDGET: Final = 0.02
"""Wall time that one session may use for its steps in one frame [s]; beyond it simulated time slows down, but no step is dropped."""

TOGETHER: Final = 2
"""As many sessions as this have the whole of it; more share what these have, so that frames stay short for all."""

SLOWEST: Final = 1.0 / 22.0
"""Steps make a frame no longer than this [s], where drawing leaves so much time; simulated time slows down first."""

LEAST: Final = 0.01
"""Wall time that the steps of all sessions have in every frame, however long drawing takes [s]."""

LONGEST_GAP: Final = 0.1
"""A pause of the program (a closed laptop, a debugger) is not caught up beyond this [s]."""

SLOW, OVER = 0.5, 0.15
"""Share of late frames in the last second beyond which a run counts as slowed, and below which it does no longer."""

SPEEDS: Final = (0.25, 0.5, 1.0, 2.0)
"""What the speed may be, simulated over wall time."""


@dataclass(frozen=True)
class Pace:
    """How the clock runs.

    Attributes:
        paused: nothing moves.
        rate: simulated seconds per wall second, over the last half second or so.
        slowed: the machine cannot keep up with the speed asked for.
    """

    paused: bool
    rate: float
    slowed: bool


def budget_of(sessions: int, drawing: float = 0.0) -> float:
    """Wall time that each of `sessions` sessions may use for its steps in one frame [s].

    Args:
        drawing: wall time of everything else in a frame of them all [s].
    """
    together = min(max(SLOWEST - drawing, LEAST), BUDGET * TOGETHER)
    return together / max(sessions, TOGETHER)


def next_speed(speed: float, by: int) -> float:
    """Return the next slower (−1) or faster (+1) speed, or the last one there is."""
    nearest = min(range(len(SPEEDS)), key=lambda i: abs(SPEEDS[i] - speed))
    return SPEEDS[min(max(nearest + by, 0), len(SPEEDS) - 1)]


class Clock:
    """Turns wall time into steps.

    Args:
        speed: simulated over wall time, to begin with.
    """

    def __init__(self, speed: float) -> None:
        self._debt = 0.0
        self._rate = speed
        self._slowness, self._slowed = 0.0, False

    def forget(self) -> None:
        self._debt = 0.0

    def due(self, elapsed: float, dt: float, speed: float) -> int:
        """Number of steps of `dt` [s] to make after `elapsed` [s] of wall time."""
        self._debt += min(elapsed, LONGEST_GAP) * speed
        return int(self._debt / dt + 1e-9)

    def note(self, made: int, due: int, elapsed: float, dt: float) -> None:
        """Take note of how many of the steps were made; what could not be made in time is not owed any more."""
        late = made < due or elapsed > LONGEST_GAP
        self._debt = 0.0 if late else self._debt - made * dt
        if elapsed > 0.0:
            self._rate += (made * dt / elapsed - self._rate) * min(elapsed / 0.5, 1.0)
            self._slowness += ((1.0 if late else 0.0) - self._slowness) * min(elapsed / 1.0, 1.0)
            # Said at once, and until it is clearly over: what comes and goes several times a second cannot be read.
            self._slowed = self._slowness > (OVER if self._slowed else SLOW)

    def pace(self, paused: bool) -> Pace:
        """State of the clock."""
        return Pace(paused, 0.0 if paused else self._rate, self._slowed and not paused)


Reason = Literal["visitor", "lesson", "replay", "class", "teacher", "hidden"]
"""The visitor pauses; a lesson waits for Run or has come to its end; a replay is shown; the teacher pauses the session that all share;
the teacher pauses the visitor's own session; the visitor's tab is out of sight."""

NOT_THE_VISITORS: Final[frozenset[Reason]] = frozenset(("teacher", "hidden"))
"""Reasons that the visitor cannot lift."""


class Halt(set[Reason]):
    """The reasons for which no step is made; false while there is none."""

    def set(self, reason: Reason, halted: bool = True) -> None:
        """Set a reason, or lift it."""
        if halted:
            self.add(reason)
        else:
            self.discard(reason)

    def go_on(self) -> None:
        """Lift every reason that is the visitor's to lift."""
        self.intersection_update(NOT_THE_VISITORS)
