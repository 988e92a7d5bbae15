"""What a page can show in the place of the live session: a moment of a replay."""

from dataclasses import replace
from typing import NamedTuple, Protocol

from app.session.clock import Halt, Pace
from app.session.replay import Replay
from app.session.student_law import LawStatus
from app.settings import Settings
from controllers.errors import LazyText
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


class Live(Protocol):
    """The live run, as what replays a part of it reads and stops it; see `Session`."""

    settings: Settings
    simulation: Simulation
    halt: Halt

    @property
    def traced(self) -> "tuple[Simulation, Simulation | None]":
        """The run and its ghost, as plots over time draw them."""
        ...

    def recorded(self, seconds: float) -> Recorded | None:
        """Return the newest piece of the run [s] as it can be made again; None if there is none."""
        ...

    def ghost_recorded(self, seconds: float) -> Recorded | None:
        """Return the newest piece of the ghost's run [s]; None if there is none."""
        ...


class Past:
    """A replay as a page reads it in the place of a session: nothing is held there.

    Args:
        replay: where it stands.
        settings: of the live session; the page stays as it is, the run is that of the replay.
        file: name of the loaded file that is replayed; "" for the session's own run.
        beside: of the ghost, at the same moment; None where there is none.
        live: the run of which this is a moment, as all of it is drawn; None of a replay by itself.
        mark: the moment that is worth a look; None if there is none.

    Attributes:
        reviewed: whether it is a moment of the live run, which stands meanwhile, so that what is known of all of it holds.
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
        self._replay, self._settings, self._live = replay, settings, live
        self.replayed_file, self.reviewed, self.mark = file, live is not None, mark
        self.ghost = None if beside is None else beside.simulation
        law = replay.recorded.law
        self.student_law = LawStatus() if law is None else LawStatus(law.file, sha256=law.sha256)

    @property
    def simulation(self) -> Simulation:
        return self._replay.simulation

    @property
    def settings(self) -> Settings:
        """Those of the run then, with those of the page now."""
        page = self._settings.page if self.reviewed else replace(self._settings.page, ghost="off")
        return replace(self._settings, run=self._replay.simulation.settings, page=page)

    @property
    def traced(self) -> tuple[Simulation, Simulation | None]:
        """The run and its ghost as plots over time draw them: as far as their axis goes."""
        return (self._replay.traced, None) if self._live is None else self._live.traced

    @property
    def pace(self) -> Pace:
        return Pace(not self._replay.playing, self._replay.speed, False)

    @property
    def replay_time(self) -> float:
        """The moment that is replayed, on the clock of the run [s]."""
        return self._replay.time

    def target(self) -> Target | None:
        return self._replay.target
