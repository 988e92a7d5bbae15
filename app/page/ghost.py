"""A second run beside the first: arms that one can see through, where their joints differ."""

from typing import Final

import numpy as np
import viser

from app.page.arms import ArmView, robot_of
from controllers.kinematics import Array
from scenes.simulation import Simulation

DIFFERENT: Final = 0.01
"""A ghost is shown from this difference of any joint on … [rad]"""

SAME: Final = 0.003
"""… and hidden below this one."""


class GhostView:
    """The ghost's arms; made when they are first seen.

    Args:
        scene: where to draw.
        fine: kind of picture.
    """

    def __init__(self, scene: viser.SceneApi, fine: bool) -> None:
        self._scene, self._fine = scene, fine
        self._arms: dict[str, ArmView] = {}

    def show(self, simulation: Simulation, ghost: Simulation | None) -> None:
        """Draw every arm of the ghost that stands elsewhere than the arm itself."""
        if ghost is None or ghost.room is not simulation.room:
            self.remove()
            return
        robot_name = robot_of(simulation)
        for arm, base in zip(ghost.room.arms, ghost.room.bases(), strict=True):
            q: Array = ghost.positions[arm.joints]
            away = float(np.abs(q - simulation.positions[arm.joints]).max())
            view = self._arms.get(arm.name)
            if view is None:
                if away < DIFFERENT:
                    continue
                view = self._arms[arm.name] = ArmView(self._scene, f"/ghost/{arm.name}", base, "ghost", self._fine, robot_name)
            view.visible = away > (SAME if view.visible else DIFFERENT)
            if view.visible:
                view.show(q)

    def remove(self) -> None:
        """Take the ghost out of the scene."""
        for view in self._arms.values():
            view.remove()
        self._arms.clear()
