"""Translucent arms, drawn where they differ from the real ones: those of the ghost's run, and the desired posture of followers."""

from typing import Final, Literal

import numpy as np
import viser

from app.session.frame import Frame
from app.settings import PageSettings
from app.stage.arms import ArmView
from controllers.kinematics import Array
from scenes.simulation import Simulation

DIFFERENT: Final = 0.02
"""A ghost is shown from this difference of any joint on … [rad]"""

SAME: Final = 0.008
"""… and hidden below this one."""


class TranslucentArms:
    """A part of the stage: copies of its arms, which look the same in every theme; each is made when it is first seen.

    Args:
        scene: where to draw.
        fine: with every triangle, see `ArmView`.
    """

    palette: Literal["ghost", "wish"]
    """Bluish for the ghost, reddish for a desired posture ("wish")."""

    def __init__(self, scene: viser.SceneApi, fine: bool) -> None:
        self._scene, self._fine = scene, fine
        self._arms: dict[str, ArmView] = {}

    def dress(self, page: PageSettings) -> None:
        """Leave the arms as they are."""

    def _draw(self, simulation: Simulation, positions: Array) -> None:
        """Draw every arm with joints q (nv,) [rad] that differ from those of the run; nan differs from nothing."""
        room = simulation.room
        for arm, base, made in zip(room.arms, room.bases(), room.robots, strict=True):
            q: Array = positions[arm.joints]
            away = float(np.abs(q - simulation.positions[arm.joints]).max())
            view = self._arms.get(arm.name)
            if view is None:
                if not away > DIFFERENT:
                    continue
                name = f"/{self.palette}/{arm.name}"
                view = ArmView(self._scene, name, base, self.palette, self._fine, made.key)
                self._arms[arm.name] = view
            view.visible = away > (SAME if view.visible else DIFFERENT)
            if view.visible:
                view.show(q)

    def remove(self) -> None:
        for view in self._arms.values():
            view.remove()
        self._arms.clear()


class GhostView(TranslucentArms):
    """The arms of the ghost's run, where there is one in the same room."""

    palette = "ghost"

    def show(self, frame: Frame) -> None:
        """Draw the present posture."""
        ghost = frame.ghost
        if ghost is not None and ghost.room is frame.simulation.room:
            self._draw(frame.simulation, ghost.positions)
        else:
            self.remove()


class WishView(TranslucentArms):
    """The desired posture q_d of the followers."""

    palette = "wish"

    def show(self, frame: Frame) -> None:
        """Draw q_d of the newest step."""
        self._draw(frame.simulation, frame.sample.desired)
