"""h and J_a of every first task against finite differences and independent code."""

import math

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose

from controllers.first_tasks.centre_of_mass import CentreOfMass, Foot
from controllers.first_tasks.joint_stops import SHARPNESS as STOPS_SHARPNESS
from controllers.first_tasks.links_over_boxes import LinksOverBoxes
from controllers.first_tasks.several_at_once import SeveralAtOnce
from controllers.first_tasks.smallest_singular_value import SmallestSingularValue
from tests.controllers.first_tasks.helpers import NAMES, PosedTask, posed, postures
from tests.controllers.helpers import derivative

EXACT = 1e-8


def row_error(of: PosedTask, q: np.ndarray) -> float:
    of.at(q)
    row = of.task.margin().row
    numeric = derivative(lambda x: np.array(of.value(x)), q)
    return float(np.abs(row - numeric).max())


def one_derivative(of: PosedTask, q: np.ndarray) -> bool:
    if not isinstance(of.task, SmallestSingularValue):
        return True
    of.at(q)
    values = np.linalg.svd(of.world.kinematics.hand_jacobian(of.arm, 3), compute_uv=False)
    return bool(values[1] - values[2] > 0.05 and values[2] > 1e-3)


@pytest.mark.parametrize("name", NAMES)
def test_the_row_is_the_derivative_of_the_value(name: str) -> None:
    of = posed(name)
    beyond = 0.3 if name == "joint stops" else 0.0
    drawn = [q for q in postures(of, 600, 3, beyond) if one_derivative(of, q)]
    values = [of.value(q) for q in drawn]
    critical = of.task.critical_value
    near = [q for q, h in zip(drawn, values, strict=True) if 0.0 <= h < critical][:25]
    # Deeper, a link's axis is inside the box and the nearest face changes; where two axes cross, the side.
    deepest = -0.045 if name in ("a bench and the floor", "surroundings") else -np.inf
    below = [q for q, h in zip(drawn, values, strict=True) if deepest < h < 0.0][:25]
    far = [q for q, h in zip(drawn, values, strict=True) if h >= critical][:25]
    assert len(near) >= 3 and len(far) >= 10
    assert len(below) >= 3 or name == "singular value"
    assert max(row_error(of, q) for q in (*near, *below, *far)) < EXACT


@pytest.mark.parametrize("name", [name for name in NAMES if name != "singular value"])
def test_the_row_is_the_derivative_where_the_arm_is_singular(name: str) -> None:
    """Stretched upwards, and with a straight elbow: the hand cannot move in one direction."""
    of = posed(name)
    straight = np.array([0.4, 0.9, -0.3, 0.0, 0.6, 0.0, 0.2])
    for q in (np.zeros(7), straight):
        of.at(q)
        assert np.linalg.svd(of.world.kinematics.hand_jacobian(of.arm, 3), compute_uv=False)[-1] < 1e-9
        assert row_error(of, q) < EXACT


def test_at_a_singular_posture_the_value_is_zero_with_a_finite_row() -> None:
    of = posed("singular value")
    of.at(np.array([0.4, 0.9, -0.3, 0.0, 0.6, 0.0, 0.2]))
    margin = of.task.margin()
    assert margin.value < 1e-9 and np.isfinite(margin.row).all() and float(np.abs(margin.row).max()) < 2.0


def test_the_singular_value_is_that_of_the_decomposition() -> None:
    of = posed("singular value")
    for q in postures(of, 200, 5):
        of.at(q)
        values = np.linalg.svd(of.world.kinematics.hand_jacobian(of.arm, 3), compute_uv=False)
        assert of.task.margin().value == pytest.approx(values[-1], abs=1e-12)


def test_the_margin_to_the_stops_is_slightly_below_the_least_distance() -> None:
    of = posed("joint stops")
    for q in postures(of, 100, 6, beyond=0.2):
        least = float(min((q - of.low).min(), (of.high - q).min()))
        assert least - math.log(14) / STOPS_SHARPNESS - 1e-12 <= of.value(q) <= least


def test_midway_the_row_of_the_stops_vanishes() -> None:
    of = posed("joint stops")
    of.at((of.low + of.high) / 2.0)
    assert_allclose(of.task.margin().row, 0.0, atol=1e-15)


def test_over_a_table_the_value_is_that_of_the_lowest_point() -> None:
    of = posed("a table")
    for q in postures(of, 100, 7):
        value, data = of.value(q), of.world.kinematics.data
        joints = [data.oMi[joint].translation[2] for joint in (of.arm.elbow, of.arm.wrist)]
        least = min(*joints, of.world.kinematics.hand_pose(of.arm).translation[2]) - 0.75
        assert least - math.log(3) / 100.0 - 1e-12 <= value <= least


def test_a_wall_that_moves_and_turns_approaches_at_w() -> None:
    of = posed("a wall that moves and turns")
    still = np.zeros(7)
    for q in postures(of, 50, 8):
        of.at(q)
        w, step = of.task.margin().approach, 1e-6
        assert w == pytest.approx(
            -(of.value_after(q, still, step) - of.value_after(q, still, -step)) / (2.0 * step), abs=EXACT
        )


def test_own_links_are_never_farther_apart_than_by_coal() -> None:
    of = posed("own links")
    geometry = of.task._geometry  # pyright: ignore[reportAttributeAccessIssue]
    data, inside = geometry.createData(), 0
    names = [body.name for body in geometry.geometryObjects]
    pairs = {(names[pair.first], names[pair.second]) for pair in geometry.collisionPairs}
    assert pairs == {
        ("arm pedestal", "arm forearm"),
        ("arm pedestal", "arm hand"),
        ("arm upper arm", "arm hand"),
    }
    for q in postures(of, 200, 9):
        value = of.value(q)
        pin.updateGeometryPlacements(of.room.model, of.world.kinematics.data, geometry, data)
        pin.computeDistances(geometry, data)
        least = min(result.min_distance for result in data.distanceResults)
        inside += least < 0.0
        assert least - math.log(3) / 100.0 - math.sqrt(0.5e-4) - 1e-12 <= value <= least + 1e-12
    assert inside >= 3


def test_a_capsule_over_boxes_is_a_little_nearer_than_its_samples_are() -> None:
    """Reference: the nearest of 401 points per axis, for three capsules and two boxes."""
    of = posed("a bench and the floor")
    task, inside = of.task, 0
    assert isinstance(task, LinksOverBoxes)
    for q in postures(of, 150, 13):
        value, nearest = of.value(q), math.inf
        for M, own, radius in zip(task._placements.read(), task._capsules, task._radii, strict=True):
            R, o = M[:9].reshape(3, 3).T, M[9:]
            points = (R @ own[:3] + o) + np.linspace(-1.0, 1.0, 401)[:, None] * (R @ own[3:])
            for box in task._boxes:
                beyond = np.abs(points - box[:3]) - box[3:]
                distances = np.linalg.norm(np.maximum(beyond, 0.0), axis=1) + np.minimum(
                    beyond.max(axis=1), 0.0
                )
                nearest = min(nearest, float(distances.min()) - radius)
        inside += nearest < 0.0
        assert nearest - math.log(6) / 100.0 - 0.0025 - 1e-4 <= value <= nearest + 1e-12
    assert inside >= 5


def test_several_at_once_follow_the_least_ratio() -> None:
    of = posed("several at once")
    assert isinstance(of.task, SeveralAtOnce)
    first, leading = of.task.critical_value, set[int]()
    for q in postures(of, 150, 14):
        value = of.value(q)
        ratios = [task.margin().value / task.critical_value for task in of.task.tasks]
        leading.add(int(np.argmin(ratios)))
        assert min(ratios) - math.log(3) / 5.0 - 1e-12 <= value / first <= min(ratios)
    assert leading == {0, 1, 2}


def test_the_centre_of_mass_is_that_of_pinocchio_with_load_and_cart() -> None:
    of = posed("centre of mass")
    base = of.room.rig.bases[0].translation
    model, data = of.room.model, of.room.model.createData()
    hand = model.frames[of.arm.hand]
    for q in postures(of, 60, 10):
        value = of.value(q)
        arm_mass = sum(model.inertias[joint].mass for joint in range(1, 8))
        arm = pin.centerOfMass(model, data, q)
        assert pin.computeTotalMass(model) == pytest.approx(arm_mass)
        pin.framesForwardKinematics(model, data, q)
        load = data.oMi[hand.parentJoint].act(hand.placement.translation)
        centre = (arm_mass * arm + 3.0 * load + 40.0 * (base - [0.0, 0.0, 0.4])) / (arm_mass + 43.0)
        least = float((np.array([0.16, 0.14]) - np.abs(centre - base + [0.09, 0.0, 0.0])[:2]).min())
        assert least - math.log(4) / 100.0 - 1e-12 <= value <= least + 1e-12


def test_without_a_load_nothing_is_added_to_the_last_link() -> None:
    of = posed("centre of mass")
    foot = Foot(np.zeros(2), np.ones(2), 10.0, np.zeros(3))
    plain = CentreOfMass(of.world.kinematics, of.arm, foot)
    of.at(np.zeros(7))
    loaded = CentreOfMass(of.world.kinematics, of.arm, foot, load=1e-9)
    assert plain.margin().value == pytest.approx(loaded.margin().value, abs=1e-9)


def test_the_distance_of_the_arms_is_that_of_the_detector() -> None:
    of = posed("the other arm")
    for q in postures(of, 40, 11):
        of.at(q)
        margin, near = of.task.margin(), of.world.detector.detect("smooth")
        other = of.room.arms[1].joints
        assert margin.value == near.law_distance
        assert (margin.row == near.row[of.arm.joints]).all()
        assert margin.approach == pytest.approx(
            -float(near.row[other] @ of.world.velocities[other]), abs=1e-14
        )
