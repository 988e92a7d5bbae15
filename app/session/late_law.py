"""A law that may answer later, for run or ghost."""

from collections.abc import Callable
from typing import Final, NamedTuple

from app.runtime.job_pool import Jobs
from controllers.laws.situation import Law
from scenes.settings import RunSettings

GHOST: Final = "own"


class LateLawStatus(NamedTuple):
    """State of a late law, for the page.

    Attributes:
        file: name of the custom law's file; None if the settings' law runs.
        ghost_file: the same of the ghost.
        problem: reason why the law fails and its arm stops, or "".
        away: the file is gone; its last law stays in force.
        slow: duration of a call, and the limit for real time [s]; None unless the run is slowed.
        line: line of `problem` in the file, from 1, or None.
    """

    file: str | None = None
    ghost_file: str | None = None
    problem: str = ""
    away: bool = False
    waits: bool = False
    slow: tuple[float, float] | None = None
    sha256: str = ""
    line: int | None = None


class LateLaw:
    """No law; a subclass has one, which raises `controllers.laws.situation.Unanswered` without an answer.

    All methods belong to the thread that advances the session. `in_ghost`: True if the ghost uses the law,
    not the run.
    """

    in_ghost = False

    @property
    def given(self) -> bool:
        """True if there is a law, even an unused one."""
        return False

    @property
    def of_run(self) -> Law | None:
        return None

    @property
    def of_ghost(self) -> Law | None:
        return None

    @property
    def waits(self) -> bool:
        """True while steps wait for the law's answer."""
        return False

    def status(self, late: bool) -> LateLawStatus:
        """State of the law. `late`: True if the run cannot keep up with the chosen speed."""
        del late
        return LateLawStatus()

    def advance(self, elapsed: float, paused: bool) -> None:
        """Compute within a frame. `elapsed`: wall time since the last frame [s]."""

    def step_made(self, run: RunSettings, speed: float) -> None:
        """Called after a step of both runs. `speed`: simulated over wall time."""

    def close(self) -> None:
        """Release resources."""


LateLawMaker = Callable[[Jobs | None, Callable[[], None]], LateLaw]


def no_law(background: Jobs | None, wake: Callable[[], None]) -> LateLaw:
    del background, wake
    return LateLaw()
