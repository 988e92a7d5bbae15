"""The handles on the figure: wrists and elbows to pull; the robots imitate what they see."""

from collections.abc import Callable
from typing import Final, get_args

import viser

from app.page.figure import on_person, on_stage
from app.page.grip import Grip
from app.page.theme import BRAND
from app.session import Session
from controllers.kinematics import Array
from scenes.person.figure import Figure
from scenes.settings import ArmName
from scenes.targets import AnglesTarget

RADIUS: Final = 0.036
"""Of a handle [m]."""


class FigureHandles:
    """The figure stays as it was pulled.

    Args:
        scene: of whoever has the controls.
        session: of an imitation.
    """

    def __init__(self, scene: viser.SceneApi, session: Session) -> None:
        self._session = session
        present = session.target()
        # It begins as the person stood who was imitated before.
        seen = present.angles if isinstance(present, AnglesTarget) else None
        self._figure = Figure() if seen is None else Figure(start=seen)
        drags = {"elbow": self._figure.drag_elbow, "wrist": self._figure.drag_wrist}
        self._grips: dict[tuple[ArmName, str], Grip] = {
            (side, joint): Grip(
                scene, f"/gizmo/{side}_{joint}", RADIUS, BRAND, 0.8, session.post, self._pulling(side, drags[joint])
            )
            for side in get_args(ArmName)
            for joint in drags
        }
        self._take()

    @property
    def dragged(self) -> bool:
        """Whether somebody has hold of it."""
        return any(grip.held for grip in self._grips.values())

    def _pulling(self, side: ArmName, drag: Callable[[ArmName, Array], None]) -> Callable[[Array | None], None]:
        def pulled(place: Array | None) -> None:
            if place is not None:
                drag(side, on_person(place))
                self._take()

        return pulled

    def _take(self) -> None:
        # Nobody takes hold of a robot here, so that the autopilot need not be switched off.
        self._session.held = AnglesTarget(self._figure.angles())

    def show(self) -> None:
        """Put the handles where wrists and elbows are."""
        if self._session.held is None:
            self._take()
        for side in get_args(ArmName):
            _, elbow, wrist = self._figure.points(side)
            self._grips[side, "elbow"].put(on_stage(elbow))
            self._grips[side, "wrist"].put(on_stage(wrist))

    def forget_drag(self) -> None:
        """Stand as at the start, with nobody pulling."""
        for grip in self._grips.values():
            grip.forget()
        self._figure.reset()

    def remove(self) -> None:
        """Take them out of the scene, and leave the robots to another source."""
        for grip in self._grips.values():
            grip.remove()
        if isinstance(self._session.held, AnglesTarget):
            self._session.held = None
