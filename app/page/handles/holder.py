"""Interface for handles and keys."""

from typing import Protocol

from app.session.actions import Action
from app.settings import Settings
from controllers.kinematics import Arm, Array
from scenes.simulation import Simulation
from scenes.targets import Target


class Holder(Protocol):
    """A person who moves something; see `app.session.visitor_hand.VisitorHand`."""

    @property
    def settings(self) -> Settings: ...

    @property
    def simulation(self) -> Simulation: ...

    @property
    def arm(self) -> Arm: ...

    @property
    def held(self) -> Target | None: ...

    def hold(self, target: Target | None) -> None:
        """Hold a target from the next step on; None releases it."""
        ...

    def nudge(self, way: Array) -> None:
        """Move what the visitor holds by `way` (3,), world [m]."""
        ...

    def post(self, action: Action) -> None:
        """From any thread."""
        ...
