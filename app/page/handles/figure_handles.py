"""The handles on the figure: wrists and elbows to pull; the robots imitate what they see."""

from collections.abc import Callable
from typing import Final, get_args

import viser

from app.page.handles.pull_ball import Grip
from app.session.actions import Action, Drag
from app.session.session import Session
from app.stage.person_figure import on_person, on_stage
from app.theme import BRAND
from controllers.kinematics import Array
from scenes.person.figure import Figure
from scenes.settings import ArmName
from scenes.targets import AnglesTarget

RADIUS: Final = {"elbow": 0.044, "wrist": 0.034}
"""Of the handles [m]."""


class FigureHandles:
    """Stands in for the built-in person: the figure stays as it was pulled."""

    def __init__(self, scene: viser.SceneApi, session: Session, post: Callable[[Action], None]) -> None:
        self._session = session
        present = session.target()
        # It begins as the person stood who was imitated before.
        seen = present.angles if isinstance(present, AnglesTarget) else None
        self._figure = figure = Figure() if seen is None else Figure(start=seen)
        session.set_source(self)
        drags = {"elbow": figure.drag_elbow, "wrist": figure.drag_wrist}
        self._grips: dict[tuple[ArmName, str], Grip] = {
            (side, joint): Grip(
                scene, f"/gizmo/{side}_{joint}", RADIUS[joint], BRAND, 0.8, post, self._pulling(side, drags[joint])
            )
            for side in get_args(ArmName)
            for joint in drags
        }

    @property
    def dragged(self) -> bool:
        """Whether the visitor is dragging it."""
        return any(grip.held for grip in self._grips.values())

    def drag(self, action: Drag) -> None:
        """Follow a pull at a wrist or an elbow."""
        for grip in self._grips.values():
            grip.drag(action)

    def _pulling(self, side: ArmName, drag: Callable[[ArmName, Array], None]) -> Callable[[Array | None], None]:
        def pulled(place: Array | None) -> None:
            if place is None:
                return
            drag(side, on_person(place))
            if not self._session.settings.page.autopilot:
                # Dragging the figure makes it the source again.
                self._session.set_source(self)

        return pulled

    def target(self, time: float) -> AnglesTarget:
        """Return how the figure's arms are, at any time."""
        return AnglesTarget(self._figure.angles(time))

    def show(self) -> None:
        """Put the handles where wrists and elbows are."""
        for side in get_args(ArmName):
            _, elbow, wrist = self._figure.points(side)
            self._grips[side, "elbow"].put(on_stage(elbow))
            self._grips[side, "wrist"].put(on_stage(wrist))

    def forget_drag(self) -> None:
        """Stand as at the start, with no handle dragged."""
        for grip in self._grips.values():
            grip.forget()
        self._figure.reset()

    def remove(self) -> None:
        """Take them out of the scene, and the figure out of another experiment."""
        for grip in self._grips.values():
            grip.remove()
        if self._session.settings.run.scene != "imitation":
            # Another source of the same experiment has shown the figure out already.
            self._session.set_source(None)
