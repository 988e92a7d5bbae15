"""What a page shows: the live session, or a replay in its place."""

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
    def ghost(self) -> Simulation | None:
        """The second run at the same moment; None without one."""
        ...

    @property
    def traced(self) -> tuple[Simulation, Simulation | None]:
        """Both runs for the plots over time; the second one only if it may be seen."""
        ...

    @property
    def ghost_hidden(self) -> bool:
        """True while the ghost must not be seen yet."""
        ...

    @property
    def pace(self) -> Pace: ...

    @property
    def held(self) -> Target | None:
        """What the visitor holds, and where; None while they hold nothing."""
        ...

    def target(self) -> Target | None:
        """Target of the active source; None without a target."""
        ...

    @property
    def parts(self) -> SessionParts | None:
        """State of features; None in a replay."""
        ...

    @property
    def law_status(self) -> LateLawStatus: ...

    @property
    def replay(self) -> ReplayStatus:
        """The replay that is shown or loading."""
        ...
