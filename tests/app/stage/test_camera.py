"""The first sight of the stage shows all of it, past the panels that cover a part of the window."""

from __future__ import annotations

import math
from typing import Any, get_args

import numpy as np
import pytest

from app.stage.person_figure import on_stage
from app.stage.stage_camera import place_camera, view_of
from controllers.kinematics import Array
from scenes.room import PATH
from scenes.settings import RobotName, RunSettings, SceneName
from scenes.simulation import Simulation
from tests.app.stage.conftest import SCENES


class Lens:
    """A client's camera that only remembers."""

    def __init__(self, aspect: float) -> None:
        self.camera = self
        self.aspect, self.fov = aspect, 1.0
        self.up_direction, self.position, self.look_at = (0.0, 0.0, 1.0), np.zeros(3), np.zeros(3)

    def sees(self, point: Array, covered: float) -> bool:
        """Whether a point is in the free part of the picture."""
        ahead = np.asarray(self.look_at) - np.asarray(self.position)
        ahead /= np.linalg.norm(ahead)
        right = np.cross(ahead, self.up_direction)
        right /= np.linalg.norm(right)
        away = point - np.asarray(self.position)
        depth, slope = away @ ahead, math.tan(self.fov / 2.0)
        x, y = away @ right / depth / slope / self.aspect, away @ np.cross(right, ahead) / depth / slope
        return bool(abs(x) < 1.0 and 2.0 * covered - 1.0 < y < 1.0)


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("robot", get_args(RobotName))
@pytest.mark.parametrize(("aspect", "covered"), [(1.28, 0.34), (0.98, 0.33), (0.49, 0.48)])
def test_the_first_sight_shows_all(scene: SceneName, robot: RobotName, aspect: float, covered: float) -> None:
    for rig in ("torso", "table"):
        simulation = Simulation(RunSettings(scene=scene, robot=robot, rig=rig))
        simulation.kinematics.update(simulation.positions)
        lens: Any = Lens(aspect)
        place_camera(lens, view_of(simulation), covered)
        kinematics, points = simulation.kinematics, []
        for arm in simulation.room.arms:
            points += [kinematics.joint_point(j) for j in (arm.shoulder, arm.elbow, arm.wrist)]
            points.append(kinematics.hand_pose(arm).translation)
        if scene == "ball":
            points += [points[-1], points[-1] + PATH, simulation.positions[simulation.room.ball]]
        if scene == "imitation":
            points += [on_stage(np.array([0.0, side * 0.5, height])) for side in (-1, 1) for height in (0.4, -0.6)]
        for point in points:
            assert lens.sees(point, covered), (rig, point)
