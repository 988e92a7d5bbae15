"""The first view of other first tasks: a wall hides no joint, and a cart's foot is in the picture."""

import numpy as np
import pytest

from app.stage.camera_view import hands, joints, pose_of, project, view_of
from app.stage.wall_view import SIZE
from controllers.kinematics import Array
from scenes.first_task.wall import turn_of
from scenes.furniture import CART_HALF
from scenes.quantities import ALL, TIP, WALL
from scenes.rigs import ALONE
from scenes.settings import RunSettings
from scenes.simulation import Simulation

ASPECTS = (1440 / 900, 1024 / 768, 390 / 844)


def hidden(eye: Array, point: Array, wall: Array) -> bool:
    """True if the drawn wall is between the camera `eye` and `point`, (3,) each."""
    turn = turn_of(wall)
    a, b = (turn.T @ (place - wall[:3]) for place in (eye, point))
    if a[0] * b[0] >= 0.0:
        return False
    across = a + (b - a) * (a[0] / (a[0] - b[0]))
    return bool((np.abs(across[1:]) <= np.array(SIZE[1:]) / 2.0).all())


@pytest.mark.parametrize("first", [WALL, ALL])
def test_a_moving_wall_hides_no_joint_and_no_hand(first: str) -> None:
    simulation = Simulation(RunSettings(scene="first_task", first=first, dt=0.01))
    source, columns = simulation.source(), simulation.room.wall
    assert columns is not None
    eyes = [pose_of(view_of(simulation), aspect).eye for aspect in ASPECTS]
    usual = pose_of(ALONE.camera, ASPECTS[0]).eye
    before = 0
    while simulation.time < 14.0:
        simulation.step(source.target(simulation.time))
        if simulation.steps % 25:
            continue
        simulation.world.update()
        wall, points = simulation.positions[columns], np.vstack([joints(simulation), hands(simulation)])
        assert not any(hidden(eye, point, wall) for eye in eyes for point in points)
        before += any(hidden(usual, point, wall) for point in points)
    # From the usual side of a single arm the wall does hide some.
    assert before > 20


@pytest.mark.parametrize("first", [TIP, ALL])
@pytest.mark.parametrize("aspect", ASPECTS)
def test_the_foot_of_the_cart_and_the_hand_are_in_the_first_view(first: str, aspect: float) -> None:
    simulation = Simulation(RunSettings(scene="first_task", first=first))
    simulation.world.update()
    x, y, _ = simulation.room.rig.bases[0].translation
    a, b = CART_HALF
    corners = [[x + i * a, y + j * b, 0.0] for i in (-1, 1) for j in (-1, 1)]
    size = (800.0 * aspect, 800.0)
    pixels = project(pose_of(view_of(simulation), aspect), size, np.vstack([corners, hands(simulation)]))
    assert (pixels > 0.0).all() and (pixels < np.array(size)).all()
    without = project(pose_of(ALONE.camera, aspect), size, np.array(corners))
    assert (without[:, 1] > size[1]).any() or aspect < 1.0
