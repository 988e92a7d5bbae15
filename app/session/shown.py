"""Interface of what a page shows."""

from typing import Protocol

from app.session.clock import Pace
from app.session.late_law import LateLawStatus
from app.session.parts import SessionParts
from app.session.replay_player import ReplayStatus
from app.settings import Settings
from scenes.simulation import Simulation
from scenes.targets import Target


class Shown(Protocol):
    """A run as a page reads it: `app.session.session.Session` or `app.session.replay_player.Past`."""

    @property
    def settings(self) -> Settings: ...

    @property
    def simulation(self) -> Simulation: ...

    @property
    def ghost(self) -> Simulation | None: ...

    @property
    def traced(self) -> tuple[Simulation, Simulation | None]: ...

    @property
    def ghost_hidden(self) -> bool: ...

    @property
    def pace(self) -> Pace: ...

    @property
    def held(self) -> Target | None: ...

    def target(self) -> Target | None: ...

    @property
    def parts(self) -> SessionParts | None: ...

    @property
    def law_status(self) -> LateLawStatus: ...

    @property
    def replay(self) -> ReplayStatus: ...
