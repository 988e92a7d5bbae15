"""A guest's hand in a session."""

from collections.abc import Callable

from app.session.actions import Action, ActionQueue
from app.session.input_source import nudged
from app.session.session import Session
from app.settings import Settings
from controllers.kinematics import Arm, Array
from scenes.simulation import Simulation
from scenes.targets import HandTarget, LinkTarget, Target


class SecondHand:
    """Implements `app.page.handles.holder.Holder`.

    `posts`: waiting actions, kept out of the session's queue, where they could mean more than a pull.
    """

    def __init__(self, session: Session, do: Callable[[Action], object]) -> None:
        self.session, self.posts = session, ActionQueue(do)

    @property
    def settings(self) -> Settings:
        return self.session.settings

    @property
    def simulation(self) -> Simulation:
        return self.session.simulation

    @property
    def arm(self) -> Arm:
        return self.simulation.avoiding

    @property
    def held(self) -> Target | None:
        return self.session.hand.other

    def hold(self, target: Target | None) -> None:
        """None releases the arm; the hand's desired place stays."""
        self.session.hand.other = target if isinstance(target, (HandTarget, LinkTarget)) else None

    def nudge(self, way: Array) -> None:
        self.hold(nudged(self.simulation, self.arm, self.held, way))

    def post(self, action: Action) -> None:
        self.posts.put(action)
        self.session.wake()
