"""Arms that one can see through, drawn where they stand elsewhere than the real ones: a second run's, or how an arm ought to stand."""

from typing import Final, Literal

import numpy as np
import viser

from app.settings import PageSettings
from app.stage.arms import ArmView, robot_of
from controllers.kinematics import Array
from scenes.history import Sample
from scenes.simulation import Simulation

DIFFERENT: Final = 0.02
"""A ghost is shown from this difference of any joint on … [rad]"""

SAME: Final = 0.008
"""… and hidden below this one."""


class GhostView:
    """Ghosts of the arms on the stage; made when they are first seen.

    Args:
        scene: where to draw.
        palette: bluish for a second run ("ghost"), reddish for how an arm ought to stand ("wish").
        fine: kind of picture.
    """

    def __init__(self, scene: viser.SceneApi, palette: Literal["ghost", "wish"], fine: bool) -> None:
        self._scene, self._palette, self._fine = scene, palette, fine
        self._arms: dict[str, ArmView] = {}

    def show(self, simulation: Simulation, positions: Array) -> None:
        """Draw every arm that stands elsewhere at q (nv,) [rad] than it does now; nan stands for no matter where."""
        room = simulation.room
        for arm, base in zip(room.arms, room.bases(), strict=True):
            q: Array = positions[arm.joints]
            away = float(np.abs(q - simulation.positions[arm.joints]).max())
            view = self._arms.get(arm.name)
            if view is None:
                if not away > DIFFERENT:
                    continue
                name = f"/{self._palette}/{arm.name}"
                view = ArmView(self._scene, name, base, self._palette, self._fine, robot_of(simulation))
                self._arms[arm.name] = view
            view.visible = away > (SAME if view.visible else DIFFERENT)
            if view.visible:
                view.show(q)

    def remove(self) -> None:
        """Take them out of the scene."""
        for view in self._arms.values():
            view.remove()
        self._arms.clear()


class WishView:
    """How the followers ought to stand: q_d.

    Args:
        scene: where to draw.
        fine: kind of picture.
    """

    def __init__(self, scene: viser.SceneApi, fine: bool) -> None:
        self._ghosts = GhostView(scene, "wish", fine)

    def dress(self, page: PageSettings) -> None:
        """The same in every theme."""

    def show(self, simulation: Simulation, sample: Sample) -> None:
        """Draw q_d of the newest step."""
        self._ghosts.show(simulation, sample.desired)

    def remove(self) -> None:
        """Take them out of the scene."""
        self._ghosts.remove()
