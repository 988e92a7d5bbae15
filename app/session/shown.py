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
    """A run as a page reads it: `app.session.session.Session`, or `app.session.replay_player.Past` in its place."""

    @property
    def settings(self) -> Settings:
        """Settings of the run, and of the page."""
        ...

    @property
    def simulation(self) -> Simulation:
        """The run."""
        ...

    @property
    def ghost(self) -> Simulation | None:
        """The second run, at the same moment; None if there is no second run."""
        ...

    @property
    def traced(self) -> tuple[Simulation, Simulation | None]:
        """Both runs as the plots over time draw them; the second one only if it may be seen."""
        ...

    @property
    def ghost_hidden(self) -> bool:
        """True while the ghost may not be seen yet."""
        ...

    @property
    def pace(self) -> Pace:
        """How the clock runs."""
        ...

    @property
    def held(self) -> Target | None:
        """What the visitor holds, and where; None while they hold nothing."""
        ...

    def target(self) -> Target | None:
        """Target of the active source; None if it gives no target."""
        ...

    @property
    def parts(self) -> SessionParts | None:
        """What features keep with the session; None in a replay."""
        ...

    @property
    def law_status(self) -> LateLawStatus:
        """State of the law that may answer later."""
        ...

    @property
    def replay(self) -> ReplayStatus:
        """Which replay it is, or is coming."""
        ...
