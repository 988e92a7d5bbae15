"""Things that the pointer pulls."""

from collections.abc import Iterable
from typing import Any, get_args

import numpy as np
import viser

from app.page.handles.holder import Holder
from app.session.actions import Drag
from app.session.visitor_hand import VisitorHand
from app.stage.arms import ArmView
from app.stage.ball_view import BallView
from app.stage.person_figure import FigureView, on_person
from app.stage.stage_part import in_room
from app.stage.wall_view import WallView
from controllers.kinematics import Array
from scenes.person.figure import Figure, Grasp
from scenes.settings import ArmName
from scenes.targets import AnglesTarget, BallTarget, LinkTarget, WallTarget


class Grip:
    """Nodes; one is pulled at a time."""

    def __init__(
        self,
        nodes: Iterable[viser.FrameHandle | viser.GlbHandle | viser.IcosphereHandle | viser.BoxHandle],
        holder: Holder,
    ) -> None:
        self._holder = holder
        self._nodes = {node.name: node for node in nodes}
        self._taken: str | None = None

        async def pulled(event: viser.SceneNodeDragEvent[Any]) -> None:
            taken, to = in_room(event.start_position), in_room(event.end_position)
            holder.post(Drag(event.target.name, event.phase, to, taken=taken))

        for node in self._nodes.values():
            node.on_drag(pulled)

    @property
    def dragged(self) -> bool:
        return self._taken is not None

    def drag(self, action: Drag) -> None:
        """Ignores pulls at other nodes, and any after a reset until the pointer is released."""
        if action.handle not in self._nodes:
            return
        if action.phase != "start" and self._ended_elsewhere():
            self._taken = None
        if action.phase == "start" and action.taken is not None:
            self._taken = action.handle
            self._take(action.handle, action.taken)
        if self._taken == action.handle and action.phase == "end":
            self._taken = None
            self._let_go()
        elif self._taken == action.handle:
            self._pull(action.place)

    def _take(self, name: str, point: Array) -> None:
        """`point`: (3,), world [m]."""
        raise NotImplementedError

    def _pull(self, place: Array) -> None:
        """`place`: (3,), world [m]."""
        raise NotImplementedError

    def _let_go(self) -> None:
        self._holder.hold(None)

    def _ended_elsewhere(self) -> bool:
        return self._holder.held is None

    def show(self) -> None: ...

    def forget_drag(self) -> None:
        self._taken = None

    def remove(self, nodes_stay: bool) -> None:
        if nodes_stay:
            for node in self._nodes.values():
                node.remove_drag_callback()


class ArmGrip(Grip):
    """Pulls a link at the taken point."""

    def __init__(self, arm: ArmView, holder: Holder) -> None:
        super().__init__(arm.links, holder)
        self._joints = {link.name: joint for joint, link in enumerate(arm.links, 1)}
        self._joint, self._offset = 0, holder.simulation.positions[:0]

    def _take(self, name: str, point: Array) -> None:
        self._joint = self._joints[name]
        placement = self._holder.simulation.kinematics.data.oMi[self._holder.arm.joint(self._joint)]
        self._offset = placement.actInv(point)

    def _pull(self, place: Array) -> None:
        self._holder.hold(LinkTarget(self._joint, self._offset, place))


class BallGrip(Grip):
    """Takes the ball from the autopilot; it stays where it is released."""

    def __init__(self, view: BallView, holder: Holder) -> None:
        super().__init__((view.ball,), holder)
        self._ball, self._offset = view.ball, np.zeros(3)

    def _take(self, name: str, point: Array) -> None:
        # Taken at its surface, it must not jump by its radius.
        self._offset = point - np.asarray(self._ball.position, float)

    def _pull(self, place: Array) -> None:
        self._holder.hold(BallTarget(place - self._offset))


class WallGrip(Grip):
    """Moves the wall without turning it."""

    def __init__(self, view: WallView, holder: Holder) -> None:
        super().__init__((view.wall,), holder)
        self._offset, self._turn = np.zeros(3), np.zeros(2)

    def _take(self, name: str, point: Array) -> None:
        simulation = self._holder.simulation
        at = simulation.positions[simulation.room.wall]
        self._offset, self._turn = point - at[:3], at[3:].copy()

    def _pull(self, place: Array) -> None:
        self._holder.hold(WallTarget(place - self._offset, self._turn))


class FigureGrip(Grip):
    """A pull makes the figure the imitated person; it keeps its last posture."""

    def __init__(self, view: FigureView, hand: VisitorHand) -> None:
        self._limbs: dict[str, tuple[ArmName, bool]] = {
            view.parts[f"{side}_{limb}"].name: (side, limb == "forearm")
            for side in get_args(ArmName)
            for limb in ("upper_arm", "forearm")
            if view.parts
        }
        super().__init__((part for part in view.parts.values() if part.name in self._limbs), hand)
        self._hand, self._view = hand, view
        self._figure: Figure | None = None
        self._grasp: Grasp | None = None

    def _take(self, name: str, point: Array) -> None:
        if self._hand.settings.page.source != "figure":
            self._hand.choose_source("figure")
            self._begin()
        assert self._figure is not None
        self._grasp = self._figure.grasp(*self._limbs[name], on_person(point))

    def _pull(self, place: Array) -> None:
        assert self._figure is not None and self._grasp is not None
        self._figure.pull(self._grasp, on_person(place))
        if not self._hand.settings.page.autopilot:
            # A pull makes it the source again.
            self._hand.set_source(self)

    def _let_go(self) -> None:
        self._grasp = None

    def _ended_elsewhere(self) -> bool:
        # The figure is a source: the session holds nothing while it is pulled.
        return self._grasp is None

    def _begin(self) -> None:
        drawn = self._view.angles
        self._figure = Figure(drawn) if np.isfinite(drawn).all() else Figure()
        self._hand.set_source(self)

    def target(self, time: float) -> AnglesTarget:
        return AnglesTarget(None if self._figure is None else self._figure.angles(time))

    def show(self) -> None:
        """Begin or end, as the settings choose the source."""
        chosen = self._hand.settings.page.source == "figure"
        if chosen and self._figure is None:
            self._begin()
        elif not chosen:
            self._figure = None

    def forget_drag(self) -> None:
        super().forget_drag()
        if self._figure is not None:
            self._figure.reset()

    def remove(self, nodes_stay: bool) -> None:
        super().remove(nodes_stay)
        if self._figure is not None and self._hand.settings.run.experiment.moves != "person":
            self._hand.set_source(None)
