"""A law that may answer later, for the session's run or its ghost."""

from collections.abc import Callable
from typing import Final, NamedTuple

from app.runtime.job_pool import Jobs
from controllers.laws.situation import Law
from scenes.settings import RunSettings

GHOST: Final = "own"


class LateLawStatus(NamedTuple):
    """State of a late law, for the page.

    Attributes:
        file: name of the file of the law that replaces the settings' law; None if the settings' law runs.
        ghost_file: the same of the ghost.
        problem: reason why the law is not in force and its arm stands still; "" if all is well, or no run
            uses it.
        away: the file is gone; the last law that was read stays in force.
        waits: the run waits for the law's answer.
        slow: duration of a call, and the limit for real time [s]; None unless the law slows down the run.
        line: of the file that `problem` is about, counted from 1; None if no line.
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
    """No law; a subclass has one. A law without an answer raises `controllers.laws.situation.Unanswered`.

    All methods belong to the thread that advances the session.

    Attributes:
        in_ghost: the ghost uses it, not the run.
    """

    in_ghost = False

    @property
    def given(self) -> bool:
        """True if there is a law, even if neither the run nor its ghost uses it."""
        return False

    @property
    def of_run(self) -> Law | None:
        return None

    @property
    def of_ghost(self) -> Law | None:
        return None

    @property
    def waits(self) -> bool:
        """True while no step is made because the law has not answered."""
        return False

    def status(self, late: bool) -> LateLawStatus:
        """State of the law. `late`: the run cannot keep up with the chosen speed."""
        del late
        return LateLawStatus()

    def advance(self, elapsed: float, paused: bool) -> None:
        """Compute within a frame. `elapsed`: wall time since the last one [s]."""

    def step_made(self, run: RunSettings, speed: float) -> None:
        """Called after a step of both runs. `speed`: simulated over wall time."""

    def close(self) -> None:
        """Release resources, such as a process."""


LateLawMaker = Callable[[Jobs | None, Callable[[], None]], LateLaw]
"""Makes the law of a session from its background jobs and its wake function."""


def no_law(background: Jobs | None, wake: Callable[[], None]) -> LateLaw:
    del background, wake
    return LateLaw()
