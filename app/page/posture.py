"""How the followers should stand: thin sticks from joint to joint inside the arms, which come out where an arm gives way."""

from typing import Final

import numpy as np
import pinocchio as pin
import viser

from app.page.theme import PALETTES, rgb, scale
from app.settings import PageSettings
from controllers.kinematics import Arm, Array
from scenes.history import Sample
from scenes.simulation import Simulation

AWAY: Final = 0.02
"""Sticks are drawn where a joint of the arm is this far from its desired place [m]."""


class DesiredPosture:
    """Shoulder, elbow, wrist and hand of every arm that follows joints, at q_d.

    Args:
        scene: where to draw.
        simulation: in which somebody follows joints.
    """

    def __init__(self, scene: viser.SceneApi, simulation: Simulation) -> None:
        room = simulation.room
        columns = {mover.joints.start for mover in simulation.cast.movers if mover.desired is not None}
        self._model, self._data = room.model, room.model.createData()
        self._positions = room.start.copy()
        self._sticks = [_Sticks(scene, arm) for arm in room.arms if arm.joints.start in columns]
        self._desired: Array | None = None

    def dress(self, page: PageSettings) -> None:
        """Take on a theme and a profile."""
        for sticks in self._sticks:
            sticks.dress(page)

    def show(self, simulation: Simulation, sample: Sample) -> None:
        """Draw q_d of the newest step."""
        q, desired = self._positions, sample.desired
        q[:] = np.where(np.isnan(desired), simulation.positions, desired)
        pin.framesForwardKinematics(self._model, self._data, q)
        for sticks in self._sticks:
            sticks.show(simulation, self._data)

    def remove(self) -> None:
        """Take them out of the scene."""
        for sticks in self._sticks:
            sticks.remove()


class _Sticks:
    """Of one arm."""

    def __init__(self, scene: viser.SceneApi, arm: Arm) -> None:
        self._arm = arm
        self._line = scene.add_line_segments(
            f"/desired/{arm.name}",
            np.zeros((3, 2, 3), np.float32),
            (0, 0, 0),
            thickness=3,
            thickness_units="screen",
            visible=False,
        )
        self._knots = [
            scene.add_icosphere(f"/desired/{arm.name}_{name}", radius=0.016, subdivisions=2, cast_shadow=False, visible=False)
            for name in ("elbow", "wrist", "hand")
        ]
        self._seen = False
        self._shown = np.zeros((4, 3))

    def dress(self, page: PageSettings) -> None:
        error = rgb(PALETTES[page.theme].error)
        self._line.colors = np.tile(np.array(error, np.uint8), (3, 2, 1))
        self._line.thickness = 3.0 * scale(page.profile)
        for knot in self._knots:
            knot.color = error

    def show(self, simulation: Simulation, data: pin.Data) -> None:
        arm, kinematics = self._arm, simulation.kinematics
        way = np.array([*(data.oMi[j].translation for j in (arm.shoulder, arm.elbow, arm.wrist)), data.oMf[arm.hand].translation])
        actual = [kinematics.joint_point(arm.elbow), kinematics.joint_point(arm.wrist), kinematics.hand_pose(arm).translation]
        seen = float(np.abs(way[1:] - actual).max()) > AWAY
        if seen != self._seen:
            self._seen = seen
            for part in (self._line, *self._knots):
                part.visible = seen
        if seen and float(np.abs(way - self._shown).max()) > 5e-4:
            self._shown = way
            self._line.points = np.stack([way[:-1], way[1:]], axis=1).astype(np.float32)
            for knot, point in zip(self._knots, way[1:], strict=True):
                knot.position = point

    def remove(self) -> None:
        self._line.remove()
        for knot in self._knots:
            knot.remove()
