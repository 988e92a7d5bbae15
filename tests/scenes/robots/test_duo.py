"""Two robots of any kind in a room: they start well, can be dragged towards each other, and keep clear."""

import itertools
from dataclasses import replace
from typing import get_args

import coal
import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from controllers.kinematics import Arm, Array, Kinematics
from controllers.limits import VelocityBox
from scenes.guide import Guide, HandTarget
from scenes.headless import run
from scenes.rigs import RIGS
from scenes.robots import Robot, RobotName, robot, start_posture
from scenes.settings import ArmName, RigName
from tests.scenes.helpers import RIG_NAMES, column, hold_settings
from tests.scenes.robots.helpers import NAMES, OTHERS


class Duo:
    """Two arms on a rig, with the pairs of their capsules that can come closer."""

    def __init__(self, names: tuple[RobotName, RobotName], rig_name: RigName) -> None:
        rig, sides = RIGS[rig_name], get_args(ArmName)
        self.robots = [robot(name) for name in names]
        self.model, self.geometry, self.arms = pin.Model(), pin.GeometryModel(), []
        for side, arm, base in zip(sides, self.robots, (rig.left_base, rig.right_base), strict=True):
            first, before = self.model.nv, self.model.njoints - 1
            self.model = pin.appendModel(self.model, _renamed(arm.model, side), 0, base)
            hand = self.model.getFrameId(f"{side} {arm.hand}")
            landmarks = (arm.shoulder + before, arm.elbow + before, arm.wrist + before)
            self.arms.append(Arm(side, slice(first, first + arm.model.nv), hand, *landmarks, arm.labels))
            for capsule in arm.capsules:
                joint = capsule.joint + before if capsule.joint else 0
                axis = capsule.end - capsule.start
                turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), axis / np.linalg.norm(axis)).toRotationMatrix()
                pose = pin.SE3(turn, (capsule.start + capsule.end) / 2.0)
                shape = coal.Capsule(capsule.radius, float(np.linalg.norm(axis)))
                self.geometry.addGeometryObject(
                    pin.GeometryObject(f"{side} {capsule.name}", joint, pose if joint else base * pose, shape)
                )
        bodies, half = self.geometry.geometryObjects, len(self.robots[0].capsules)
        for a, b in itertools.product(range(half), range(half, len(bodies))):
            if bodies[a].parentJoint or bodies[b].parentJoint:
                self.geometry.addCollisionPair(pin.CollisionPair(a, b))
        self.start = np.concatenate(
            [start_posture(name, rig_name, side) for name, side in zip(names, sides, strict=True)], dtype=float
        )

    def distance(self, q: Array) -> float:
        """Smallest distance between the arms at q (nv,) [m]."""
        data, pairs = self.model.createData(), self.geometry.createData()
        pin.computeDistances(self.model, data, self.geometry, pairs, q)
        return min(result.min_distance for result in pairs.distanceResults)


def _renamed(model: pin.Model, side: str) -> pin.Model:
    model = model.copy()
    for i in range(1, model.njoints):
        model.names[i] = f"{side} {model.names[i]}"
    for i in range(1, model.nframes):
        model.frames[i].name = f"{side} {model.frames[i].name}"
    return model


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize("names", list(itertools.product(NAMES, NAMES)), ids="-".join)
def test_arms_start_clear_of_each_other(names: tuple[RobotName, RobotName], rig: RigName) -> None:
    """Also where the two are not of one make."""
    duo = Duo(names, rig)
    assert duo.distance(duo.start) >= 0.25


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize("name", NAMES)
def test_arms_start_far_from_their_stops_and_mirrored(name: RobotName, rig: RigName) -> None:
    """At least 15° from every stop; hands at the same height, on either side, in front."""
    duo = Duo((name, name), rig)
    room = np.minimum(duo.start - duo.model.lowerPositionLimit, duo.model.upperPositionLimit - duo.start)
    assert room.min() > np.radians(15)
    data = duo.model.createData()
    pin.framesForwardKinematics(duo.model, data, duo.start)
    left, right = (data.oMf[arm.hand].translation for arm in duo.arms)
    flip = (1, -1, 1) if rig == "torso" else (-1, -1, 1)
    assert_allclose(left, right * flip, atol=2e-3)
    assert left[0] > 0.6 if rig == "torso" else -0.45 < left[0] < -0.15
    assert 0.8 < left[2] < 1.6


def test_a_start_posture_is_a_copy() -> None:
    start_posture("lwr", "torso", "left")[0] = 9.0
    assert_array_equal(start_posture("lwr", "torso", "left"), RIGS["torso"].left_start)
    assert_array_equal(start_posture("lwr", "torso", "right"), RIGS["torso"].right_start)


def axis_points(arm: Robot, data: pin.Data, first: int) -> Array:
    """Points (k, 3) all along the axes of an arm's moving capsules."""
    return np.array(
        [
            data.oMi[capsule.joint + first].act(capsule.start + part * (capsule.end - capsule.start))
            for capsule in arm.capsules
            if capsule.joint
            for part in (0.0, 0.3, 0.7, 1.0)
        ]
    )


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize("name", NAMES)
def test_a_hand_can_be_dragged_towards_the_other_arm(name: RobotName, rig: RigName) -> None:
    """10 cm towards the other hand, reached to a millimetre, at no more than a person's speed anywhere on the arm's axes."""
    duo, dt, top_speed = Duo((name, name), rig), 0.005, 0.25
    kinematics = Kinematics(duo.model, tuple(duo.arms))
    other, arm = duo.arms
    joints, q, make = arm.joints, duo.start.copy(), duo.robots[1]
    model = duo.model
    box = VelocityBox(
        model.lowerPositionLimit[joints].copy(), model.upperPositionLimit[joints].copy(), model.velocityLimit[joints].copy(), 10.0
    )
    guide = Guide(kinematics, arm, make, box, duo.start[joints])
    kinematics.update(q)
    hand, aim = kinematics.hand_pose(arm).translation.copy(), kinematics.hand_pose(other).translation.copy()
    goal = hand + 0.10 * (aim - hand) / np.linalg.norm(aim - hand)
    first = arm.shoulder - make.shoulder
    before, fastest = axis_points(make, kinematics.data, first), 0.0
    for _ in range(400):
        box.update(q[joints])
        q[joints] += guide.follow(HandTarget(goal), q[joints], dt, top_speed) * dt
        kinematics.update(q)
        after = axis_points(make, kinematics.data, first)
        fastest = max(fastest, float(np.linalg.norm(after - before, axis=1).max()) / dt)
        before = after
    assert np.linalg.norm(kinematics.hand_pose(arm).translation - goal) < 1e-3
    assert 0.5 * top_speed < fastest <= 1.005 * top_speed
    assert 0 < duo.distance(q) < duo.distance(duo.start) + 0.01


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize("name", OTHERS)
def test_the_paper_s_law_keeps_other_robots_clear(name: RobotName, rig: RigName) -> None:
    """The autopilot's hand comes as near as with the LWR, and never nearer than d_m; the start postures are chosen for that."""
    for guided in get_args(ArmName):
        chosen = replace(hold_settings(rig, seed=2), robot=name, guided=guided)
        distances = column(run(chosen, 46.0).table, "d")
        assert chosen.law.critical_distance <= distances.min() < 1.2 * chosen.law.critical_distance
