"""The detector of first tasks: ends of the drawn line, row and value of each task."""

import numpy as np
import pytest

from controllers.first_tasks.centre_of_mass import CentreOfMass
from controllers.first_tasks.points_over_plane import PointsOverPlane
from scenes.first_task.detector import FirstTaskDetector
from scenes.first_task.place import AGAINST, POINT_RADIUS, build_first_task_room
from scenes.quantities import SINGULAR, STOPS, TIP, WALL
from scenes.room import World


def detected(first: str, seed: int, stages: bool = False) -> tuple[World, FirstTaskDetector, int]:
    """World and detector at a posture near the start, and the index of the task."""
    room = build_first_task_room(first if not stages else "all", 3.0, stages)
    world = World(room, 10.0)
    detector = world.detector
    assert isinstance(detector, FirstTaskDetector)
    away = np.random.default_rng(seed).uniform(-0.3, 0.3, room.model.nq)
    world.kinematics.update(room.start + away)
    detector.detect()
    return world, detector, [against for _, against in detector.pair_names].index(AGAINST[first])


@pytest.mark.parametrize("seed", range(5))
def test_the_line_to_a_wall_has_the_length_of_the_value_along_its_normal(seed: int) -> None:
    world, detector, pair = detected(WALL, seed)
    point, foot = detector.witness_points(pair)
    task = detector.tasks[pair]
    assert isinstance(task, PointsOverPlane)
    plane = task.plane
    over = (point - foot).dot(plane.normal)
    arm = world.room.arms[0]
    joints = [world.kinematics.joint_point(joint) for joint in (arm.elbow, arm.wrist)]
    centres = [*joints, world.kinematics.hand_pose(arm).translation]
    assert (foot - plane.point).dot(plane.normal) == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_allclose(np.cross(point - foot, plane.normal), 0.0, atol=1e-12)
    heights = [(centre - plane.point).dot(plane.normal) - POINT_RADIUS for centre in centres]
    assert over == pytest.approx(min(heights), abs=1e-12)
    # A smooth minimum is never above the minimum.
    assert detector.distances()[pair] <= over + 1e-12


@pytest.mark.parametrize("seed", range(5))
def test_the_line_of_balance_is_on_the_ground_below_the_centre_of_mass(seed: int) -> None:
    _, detector, pair = detected(TIP, seed)
    centre, edge = detector.witness_points(pair)
    task = detector.tasks[pair]
    assert isinstance(task, CentreOfMass)
    np.testing.assert_allclose(centre, [*task.centre()[:2], 0.0], atol=1e-12)
    assert edge[2] == 0.0
    assert detector.distances()[pair] <= np.linalg.norm(centre - edge) + 1e-12


def test_the_point_of_the_stops_is_the_joint_nearest_to_its_stop() -> None:
    world, detector, pair = detected(STOPS, 0)
    arm = world.room.arms[0]
    for joint in range(7):
        q = world.room.start.copy()
        q[joint] = world.room.model.upperPositionLimit[joint] - 0.05
        world.kinematics.update(q)
        detector.detect()
        for point in detector.witness_points(pair):
            np.testing.assert_array_equal(point, world.kinematics.joint_point(arm.joints.start + 1 + joint))


def test_singularity_has_no_length_and_is_at_the_hand() -> None:
    world, detector, pair = detected(SINGULAR, 0)
    hand = world.kinematics.hand_pose(world.room.arms[0]).translation
    for point in detector.witness_points(pair):
        np.testing.assert_array_equal(point, hand)


def test_with_stages_the_law_acts_on_the_first_task_only() -> None:
    _, detector, first = detected(WALL, 1, stages=True)
    near = detector.detect("soft")
    assert first == 0
    assert near.law_distance == detector.distances()[0]
    np.testing.assert_array_equal(near.row, detector.row(0))
    assert near.distance == detector.distances().min()
    np.testing.assert_array_equal(near.pair_row, detector.row(near.pair))


def test_with_ratios_the_law_acts_on_a_smooth_minimum_of_all() -> None:
    room = build_first_task_room("all", 3.0)
    world = World(room, 10.0)
    world.kinematics.update(room.start)
    assert world.detector.detect("soft").law_distance < world.detector.detect("single").law_distance
