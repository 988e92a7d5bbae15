"""Four angles per arm: meaning, round trips, mirror images, and no jump where they are not observable."""

import math
from collections.abc import Iterable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from numpy.typing import ArrayLike

from controllers.kinematics import Array
from scenes.person import angles as person
from scenes.settings import ArmName
from tests.scenes.person.strategies import SIDES, arms, bodies, plain_arms

FORWARD, LEFT, UP = np.eye(3)
EYE = np.eye(3)


def arm_angles(
    shoulder: Array, elbow: Array, wrist: Array, side: ArmName, previous: Array | None = None
) -> Array:
    upper, forearm = (bone / np.linalg.norm(bone) for bone in (elbow - shoulder, wrist - elbow))
    return person.direction_angles(upper, forearm, side, previous)


def body_points(
    angles: Array, turn: Array = EYE, place: Array = FORWARD, scale: float = 1.0
) -> person.BodyPoints:
    """Points of a body with these angles, hips half a metre below the shoulders, in any frame and scale."""
    chains = np.array([person.arm_points(angles[i], side) for i, side in enumerate(SIDES)])
    moved = (chains @ turn.T) * scale + place
    hips = turn @ np.array([0.0, 0.0, -0.5]) * scale + place
    return person.BodyPoints(moved[:, 0], moved[:, 1], moved[:, 2], hips)


@pytest.mark.parametrize(
    ("degrees", "upper", "forearm"),
    [
        ((0, 0, 0, 0), -UP, -UP), ((90, 0, 0, 0), FORWARD, FORWARD), ((180, 0, 0, 0), UP, UP), ((0, 90, 0, 0), LEFT, LEFT),
        ((0, 0, 0, 90), -UP, FORWARD), ((0, 0, 90, 90), -UP, LEFT), ((0, 0, -90, 90), -UP, -LEFT),
        ((90, 0, 0, 90), FORWARD, UP), ((0, 90, 90, 90), LEFT, UP), ((0, 90, 0, 90), LEFT, FORWARD),
    ],
)  # fmt: skip
def test_the_angles_match_the_docstring(degrees: tuple[float, ...], upper: Array, forearm: Array) -> None:
    angles = np.radians(np.array(degrees, float))
    mirror = np.array([1.0, -1.0, 1.0])
    for side, flip in zip(SIDES, (1.0, mirror), strict=True):
        found = person.arm_directions(angles, side)
        assert_allclose(found[0], upper * flip, atol=1e-12)
        assert_allclose(found[1], forearm * flip, atol=1e-12)


@given(arms)
def test_left_and_right_are_mirror_images(angles: Array) -> None:
    left, right = person.arm_points(angles, "left"), person.arm_points(angles, "right")
    for a, b in zip(left, right, strict=True):
        assert_allclose(a * [1.0, -1.0, 1.0], b, atol=1e-12)
    assert_allclose(arm_angles(*left, "left"), arm_angles(*right, "right"), atol=1e-12)


@given(arms, st.sampled_from(SIDES))
def test_turning_keeps_lengths(angles: Array, side: ArmName) -> None:
    R = person.arm_rotation(angles, side)
    assert_allclose(R @ R.T, EYE, atol=1e-12)
    assert np.linalg.det(R) > 0.0
    assert_allclose(R @ -UP, person.arm_directions(angles, side)[0], atol=1e-12)
    shoulder, elbow, wrist = person.arm_points(angles, side)
    assert math.isclose(float(np.linalg.norm(elbow - shoulder)), person.UPPER_ARM)
    assert math.isclose(float(np.linalg.norm(wrist - elbow)), person.FOREARM)


@given(plain_arms, st.sampled_from(SIDES))
def test_round_trip_of_the_angles(angles: Array, side: ArmName) -> None:
    points = person.arm_points(angles, side)
    assert_allclose(arm_angles(*points, side), angles, atol=1e-9)
    assert_allclose(arm_angles(*points, side, angles + 0.05), angles, atol=1e-9)


@given(arms, st.sampled_from(SIDES))
def test_round_trip_of_the_points(angles: Array, side: ArmName) -> None:
    points = person.arm_points(angles, side)
    back = person.arm_points(arm_angles(*points, side), side)
    assert_allclose(back, points, atol=1e-7)


@given(bodies(plain_arms), st.tuples(*[st.floats(-3.0, 3.0)] * 3), st.floats(0.01, 100.0))
def test_any_frame_and_unit(angles: Array, rotation: tuple[float, float, float], scale: float) -> None:
    a, b, c = rotation
    turn = person.arm_rotation(np.array([a, b, c, 0.0]), "left")
    points = body_points(angles, turn, np.array([5.0, -2.0, 1.0]), scale)
    R = person.torso_rotation(points.shoulders[0], points.shoulders[1], points.hips)
    assert R is not None
    assert_allclose(R, turn, atol=1e-9)
    found = person.body_angles(points)
    assert found is not None
    assert_allclose(found, angles, atol=1e-7)


def tracked(path: Iterable[ArrayLike], side: ArmName, previous: Array, noise: float = 0.0) -> Array:
    """Angles (k, 4) found along a path of true ones, each with its predecessor as memory."""
    random, found = np.random.default_rng(3), [previous]
    for angles in path:
        upper, forearm = person.arm_directions(np.array(angles), side)
        forearm = forearm + random.normal(0.0, noise, 3)
        found.append(person.direction_angles(upper, forearm / np.linalg.norm(forearm), side, found[-1]))
    return np.array(found)


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("tilt", [0.0, 0.002, -0.03])
def test_swinging_through_the_t(side: ArmName, tilt: float) -> None:
    path = [[tilt, raised, 0.0, math.radians(80.0)] for raised in np.radians(np.linspace(10.0, 170.0, 321))]
    found = tracked(path, side, np.radians([0.0, 10.0, 0.0, 80.0]))
    assert np.abs(np.diff(found, axis=0)).max() < math.radians(5.0)
    for angles, true in zip(found[1:], path, strict=True):
        assert_allclose(
            person.arm_directions(angles, side),
            person.arm_directions(np.array(true), side),
            rtol=0.0,
            atol=math.radians(3.0),
        )
    assert_allclose(found[-1], path[-1], atol=1e-3)
    # Positive control: without a memory the angles jump at the T.
    alone = [
        person.direction_angles(*person.arm_directions(np.radians([0.1, up, 0.0, 80.0]), side), side)
        for up in np.linspace(80, 100, 41)
    ]
    assert np.abs(np.diff(alone, axis=0)).max() > 2.0


def test_memory_of_angles() -> None:
    # As the elbow straightens the rotation stays, despite noise; bent again it is found again.
    elbows = [*np.linspace(90.0, 0.0, 200), *np.zeros(50), *np.linspace(0.0, 90.0, 200)]
    path = np.radians([[30.0, 20.0, 40.0, elbow] for elbow in elbows])
    found = tracked(path, "left", path[0], noise=0.002)
    assert np.abs(np.diff(found[:, 2])).max() < 0.1
    assert_allclose(found[-1], path[-1], atol=0.01)
    # Abduction continues, too, past the head and down the other side.
    found = tracked(
        ([0.09, raised, 0.0, 1.4] for raised in np.linspace(0.2, 5.5, 800)),
        "right",
        np.radians([5.0, 10.0, 0.0, 80.0]),
    )
    assert np.abs(np.diff(found, axis=0)).max() < 0.1
    assert_allclose(found[-1], [0.09, 5.5, 0.0, 1.4], atol=1e-3)
    # A windmill's flexion continues without wrapping.
    start = np.radians([0.0, 10.0, 0.0, 30.0])
    found = tracked(([flexion, *start[1:]] for flexion in np.linspace(0.0, 3.0 * np.pi, 400)), "left", start)
    assert np.abs(np.diff(found[:, 0])).max() < 0.1
    assert_allclose(found[-1, 0], 3.0 * np.pi, atol=1e-6)
    # The memory fades: a constant posture is found after some samples.
    true = np.radians([50.0, 87.0, 10.0, 80.0])
    assert_allclose(tracked([true] * 60, "left", np.radians([0.0, 87.0, 50.0, 80.0]))[-1], true, atol=1e-6)


def test_impossible_points_give_no_angles() -> None:
    whole = body_points(np.radians([[20.0, 10.0, 0.0, 60.0]] * 2))
    assert person.body_angles(whole) is not None
    for hips in (whole.shoulders[0], whole.shoulders.mean(axis=0)):
        assert person.body_angles(whole._replace(hips=hips)) is None
    elbows, wrists = whole.elbows, whole.wrists
    for place, wrong in (
        (elbows[0], whole.shoulders[0]),
        (wrists[1], elbows[1]),
        (wrists[1], np.nan),
        (elbows[1], np.inf),
    ):
        right = place.copy()
        place[:] = wrong
        assert person.body_angles(whole) is None
        place[:] = right
    assert person.body_angles(whole) is not None
