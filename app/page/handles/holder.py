"""Who moves something by handles and keys."""

from typing import Protocol

from app.session.actions import Action
from app.settings import Settings
from controllers.kinematics import Arm, Array
from scenes.simulation import Simulation
from scenes.targets import Target


class Holder(Protocol):
    """A person with a hand on an arm, a ball or a figure; see `app.session.visitor_hand.VisitorHand`."""

    @property
    def settings(self) -> Settings: ...

    @property
    def simulation(self) -> Simulation: ...

    @property
    def arm(self) -> Arm: ...

    @property
    def held(self) -> Target | None: ...

    def hold(self, target: Target | None) -> None:
        """Hold something from the next step on; None lets go."""
        ...

    def nudge(self, way: Array) -> None:
        """Move what they hold by (3,) [m], world."""
        ...

    def post(self, action: Action) -> None:
        """From any thread."""
        ...
