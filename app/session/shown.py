"""What a page can show: the live session, or a moment of a replay in its place."""

from dataclasses import replace
from typing import Protocol

import numpy as np

from app.session.clock import Halt, Pace
from app.session.replay import Replay
from app.session.student_law import LawStatus
from app.settings import Settings
from controllers.kinematics import Array
from scenes.inputs import Recorded
from scenes.simulation import Simulation
from scenes.targets import Target


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

    def recorded(self, seconds: float) -> Recorded | None:
        """Return the newest piece of the run [s] as it can be made again; None if there is none."""
        ...


class Past:
    """A replay as a page reads it, see `app.session.shown.Shown`: nothing is held there.

    Args:
        replay: where it stands.
        settings: of the live session; the page stays as it is, the run is that of the replay.
        file: name of the loaded file that is replayed; "" for the session's own run.
    """

    ghost = held = None

    def __init__(self, replay: Replay, settings: Settings, file: str = "") -> None:
        self._replay, self._live, self.replayed_file = replay, settings, file
        law = replay.recorded.law
        self.student_law = LawStatus() if law is None else LawStatus(law.file, sha256=law.sha256)

    @property
    def simulation(self) -> Simulation:
        return self._replay.simulation

    @property
    def settings(self) -> Settings:
        """Those of the run then, with those of the page now."""
        return replace(self._live, run=self._replay.simulation.settings, page=replace(self._live.page, ghost="off"))

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
