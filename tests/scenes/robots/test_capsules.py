"""Capsules enclose all of a robot that can collide, and are tight."""

import itertools

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from controllers.kinematics import Array
from scenes.robots import RobotName, robot
from scenes.robots.enclosing import GRID, SHORTEST, enclosing_capsule
from scenes.robots.example_data import EXAMPLES
from scenes.robots.fitting import build_example
from tests.scenes.robots.helpers import OTHERS, clearance, collision_points, outside, postures


@pytest.mark.parametrize("name", OTHERS)
def test_capsules_enclose_all_that_can_collide(name: RobotName) -> None:
    points = collision_points(name)
    assert sum(len(cloud) for cloud in points.values()) > 10_000
    for q in postures(robot(name).model, 15):
        assert outside(name, points, q) < 1e-9


@pytest.mark.parametrize(("name", "part"), [(name, segment.name) for name in OTHERS for segment in EXAMPLES[name].segments])
def test_capsules_are_tight(name: RobotName, part: str) -> None:
    points = collision_points(name)
    assert max(outside(name, points, q, {part: 0.003}) for q in postures(robot(name).model, 8)) > 0


def test_fitting_by_example() -> None:
    # Outside of a capsule.
    capsule = robot("lwr").capsules[1]
    points = np.array([(0.0, 0.0, 0.2), (0.1, 0.0, 0.2), (0.0, 0.0, 0.5), (0.0, -0.3, -0.4)])
    assert_allclose(clearance(capsule, points), [-0.07, 0.03, 0.03, 0.43], atol=1e-12)
    # A point like cloud gets a capsule with an axis.
    corners = 0.02 * np.array(list(itertools.product((-1, 1), repeat=3)))
    start, end, radius = enclosing_capsule(corners)
    assert np.linalg.norm(end - start) >= SHORTEST - 1e-9
    assert radius <= 0.02 * np.sqrt(3) + 2 * GRID
    # Capsules come out alike every time.
    for a, b in zip(robot("ur5").capsules, build_example(EXAMPLES["ur5"]).capsules, strict=True):
        assert_array_equal(np.r_[a.start, a.end, a.radius], np.r_[b.start, b.end, b.radius])


turns = st.tuples(*[st.floats(-3.0, 3.0)] * 3).map(lambda v: pin.exp3(np.array(v)))


@settings(max_examples=12)
@given(turns, st.floats(0.02, 0.4), st.floats(0.03, 0.12), st.integers(0, 99))
def test_a_capsule_is_found_again(turn: Array, length: float, radius: float, seed: int) -> None:
    normals = np.random.default_rng(seed).normal(size=(600, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    on_axis = np.where(normals[:, 2:] > 0, length, 0.0) * np.array([0.0, 0.0, 1.0])
    points = (radius * normals + on_axis) @ turn.T + np.array([0.1, -0.2, 0.3])
    start, end, found = enclosing_capsule(points)
    axis = end - start
    share = np.clip((points - start) @ axis / (axis @ axis), 0.0, 1.0)
    assert np.linalg.norm(points - start - share[:, None] * axis, axis=1).max() <= found + 1e-9
    volume = np.pi * found**2 * (np.linalg.norm(axis) + 4 / 3 * found)
    assert volume < 1.1 * np.pi * radius**2 * (length + 4 / 3 * radius)
