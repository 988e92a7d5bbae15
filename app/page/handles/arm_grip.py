"""The visitor's arm, taken hold of anywhere."""

from collections.abc import Callable

from app.page.handles.grip import Grip
from app.session.actions import Action
from app.session.session import Session
from app.stage.arms import ArmView
from controllers.kinematics import Array
from scenes.targets import LinkTarget


class ArmGrip(Grip):
    """A pull at a link is a pull at the point of it that was taken."""

    def __init__(self, arm: ArmView, session: Session, post: Callable[[Action], None]) -> None:
        super().__init__(arm.links, post)
        self._session = session
        self._joints = {link.name: joint for joint, link in enumerate(arm.links, 1)}
        self._joint, self._offset = 0, session.simulation.positions[:0]

    def _take(self, name: str, point: Array) -> None:
        simulation = self._session.simulation
        self._joint = self._joints[name]
        placement = simulation.kinematics.data.oMi[simulation.guided.joint(self._joint)]
        self._offset = placement.actInv(point)

    def _pull(self, place: Array) -> None:
        self._session.hold(LinkTarget(self._joint, self._offset, place))

    def _let_go(self) -> None:
        self._session.hold(None)
