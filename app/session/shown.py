"""What a page can show: the live session, or a moment of a replay in its place."""

from dataclasses import replace
from typing import NamedTuple, Protocol

import numpy as np

from app.session.clock import Halt, Pace
from app.session.replay import Replay
from app.session.student_law import LawStatus
from app.settings import Settings
from controllers.errors import LazyText
from controllers.kinematics import Array
from scenes.inputs import Recorded
from scenes.simulation import Simulation
from scenes.targets import Target


class Mark(NamedTuple):
    """A moment of a run that is worth a look.

    Attributes:
        time: on the clock of the run [s].
        name: what is then, in the visitor's language once it is read by `tr`.
    """

    time: float
    name: LazyText


class Shown(Protocol):
    """A run as a page reads it."""

    @property
    def simulation(self) -> Simulation:
        """The run, with its history."""
        ...

    @property
    def ghost(self) -> Simulation | None:
        """The second run beside it."""
        ...

    @property
    def settings(self) -> Settings:
        """Of the run that is shown, and of the page."""
        ...

    @property
    def pace(self) -> Pace:
        """How fast it goes."""
        ...

    @property
    def held(self) -> Target | None:
        """What the visitor holds."""
        ...

    @property
    def replay_time(self) -> float | None:
        """The moment that is replayed, on the clock of the run [s]; None while live."""
        ...

    @property
    def reviewed(self) -> bool:
        """Whether it is a moment of the live run, which stands meanwhile, so that what is known of all of it holds."""
        ...

    @property
    def mark(self) -> Mark | None:
        """The moment of a replay that is worth a look."""
        ...

    @property
    def traced(self) -> "tuple[Simulation, Simulation | None]":
        """The run and its ghost as plots over time draw them: of a replay as far as their axis goes."""
        ...

    @property
    def replayed_file(self) -> str:
        """Name of the loaded file that is replayed; "" for the session's own run."""
        ...

    @property
    def student_law(self) -> LawStatus:
        """How the student's law fares; of a replay, which file it was."""
        ...

    def target(self) -> Target | None:
        """Return the active source's target, or None."""
        ...

    def way(self, seconds: float) -> Array:
        """Return where the hand, or the ball, will go in the next seconds (k, 3) [m]; (0, 3) if that is not known."""
        ...


class Live(Shown, Protocol):
    """The live run, as what replays a part of it reads and stops it."""

    halt: Halt

    @property
    def paused(self) -> bool:
        """Whether it stands still."""
        ...

    def ghost_recorded(self, seconds: float) -> Recorded | None:
        """Return the newest piece of the ghost's run [s]; None if there is none."""
        ...

    def recorded(self, seconds: float) -> Recorded | None:
        """Return the newest piece of the run [s] as it can be made again; None if there is none."""
        ...


class Past:
    """A replay as a page reads it, see `app.session.shown.Shown`: nothing is held there.

    Args:
        replay: where it stands.
        settings: of the live session; the page stays as it is, the run is that of the replay.
        file: name of the loaded file that is replayed; "" for the session's own run.
        beside: of the ghost, at the same moment; None where there is none.
        live: the run of which this is a moment, as all of it is drawn; None of a replay by itself.
        mark: the moment that is worth a look.
    """

    held = None

    def __init__(
        self,
        replay: Replay,
        settings: Settings,
        file: str = "",
        beside: Replay | None = None,
        live: Live | None = None,
        mark: Mark | None = None,
    ) -> None:
        self._replay, self._live, self.replayed_file = replay, settings, file
        self.ghost = None if beside is None else beside.simulation
        self.reviewed, self.mark = live is not None, mark
        self._whole = live
        law = replay.recorded.law
        self.student_law = LawStatus() if law is None else LawStatus(law.file, sha256=law.sha256)

    @property
    def simulation(self) -> Simulation:
        return self._replay.simulation

    @property
    def settings(self) -> Settings:
        """Those of the run then, with those of the page now."""
        page = self._live.page if self.reviewed else replace(self._live.page, ghost="off")
        return replace(self._live, run=self._replay.simulation.settings, page=page)

    @property
    def traced(self) -> tuple[Simulation, Simulation | None]:
        return (self._replay.traced, None) if self._whole is None else self._whole.traced

    @property
    def pace(self) -> Pace:
        return Pace(not self._replay.playing, self._replay.speed, False)

    @property
    def replay_time(self) -> float:
        return self._replay.time

    def target(self) -> Target | None:
        return self._replay.target

    def way(self, seconds: float) -> Array:
        """Return (0, 3): the replay goes where it is sent."""
        del seconds
        return np.zeros((0, 3))
