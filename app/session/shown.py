"""What a page can show: the live session, or a moment of a replay in its place."""

from typing import Protocol

from app.session.clock import Pace
from app.session.microscope import Magnified
from app.session.safety_curves import SafetyCurves
from app.session.student_law import LawStatus
from app.session.trade_off import TradeOffMap
from app.settings import Settings
from controllers.kinematics import Array
from scenes.rerun import WhatIf
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
        """How the student's law fares; none of a replay."""
        ...

    @property
    def what_if(self) -> WhatIf | None:
        """How the last part would have gone with the present settings."""
        ...

    @property
    def magnified(self) -> Magnified | None:
        """Single steps of the run; None where there are none."""
        ...

    @property
    def trade_off(self) -> TradeOffMap | None:
        """Distance against error over n and v."""
        ...

    @property
    def safety_curves(self) -> SafetyCurves | None:
        """Distance against error, law by law."""
        ...

    def target(self) -> Target | None:
        """Return the active source's target, or None."""
        ...

    def way(self, seconds: float) -> Array:
        """Return where the hand, or the ball, will go in the next seconds (k, 3) [m]; (0, 3) if that is not known."""
        ...


class Player(Protocol):
    """Replays a recorded run in the place of the live one."""

    @property
    def past(self) -> Shown | None:
        """The moment that is replayed; None while live."""
        ...

    def advance(self, elapsed: float) -> bool:
        """Play for `elapsed` [s] of wall time; return whether another moment is shown."""
        ...

    def leave(self) -> None:
        """Go back to live."""
        ...
