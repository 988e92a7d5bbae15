"""A law that may answer later: what a session knows of a law that it is given for its run or its ghost."""

from collections.abc import Callable
from typing import Final, NamedTuple

from app.runtime.job_pool import Jobs
from controllers.laws.situation import Law
from scenes.settings import RunSettings

GHOST: Final = "own"
"""Value of the setting `ghost` by which the ghost uses the law, not the run."""


class LateLawStatus(NamedTuple):
    """State of a late law, for the page.

    Attributes:
        file: name of the file of the law that runs instead of the settings' law; None if the settings' law runs.
        ghost_file: the same of the ghost.
        problem: why the law is not in force, and its arm stands still; "" if all is well, or no run uses it.
        away: True if the file is gone; the last law that was read stays in force.
        waits: True while the run waits for the law's answer.
        slow: duration of a call, and what real time allows [s]; None unless the law slows down the run.
        sha256: of the file, in hexadecimal digits.
        line: of the file that `problem` is about, counted from 1; None if it is about no line.
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
    """No law; a subclass has one. A law that has not answered yet raises `controllers.laws.situation.Unanswered`.

    All methods belong to the thread that advances the session.

    Attributes:
        in_ghost: True if the ghost uses it, not the run.
    """

    in_ghost = False

    @property
    def given(self) -> bool:
        """True if there is a law, also while neither the run nor its ghost uses it."""
        return False

    @property
    def of_run(self) -> Law | None:
        """The law, if the run uses it."""
        return None

    @property
    def of_ghost(self) -> Law | None:
        """The law, if the ghost uses it."""
        return None

    @property
    def waits(self) -> bool:
        """True while no step is made because the law has not answered yet."""
        return False

    def status(self, late: bool) -> LateLawStatus:
        """State of the law. `late`: whether the run cannot keep up with the speed asked for."""
        del late
        return LateLawStatus()

    def advance(self, elapsed: float, paused: bool) -> None:
        """Let the law have its share of a frame. `elapsed`: wall time since the last one [s]."""

    def step_made(self, run: RunSettings, speed: float) -> None:
        """Note that a step of both runs was made. `speed`: simulated over wall time."""

    def close(self) -> None:
        """Release what the law needs, such as a process."""


LateLawMaker = Callable[[Jobs | None, Callable[[], None]], LateLaw]
"""Makes the law of a session from where it may compute in the background and what asks for a frame."""


def no_law(background: Jobs | None, wake: Callable[[], None]) -> LateLaw:
    """The law of a session that is given none."""
    del background, wake
    return LateLaw()
