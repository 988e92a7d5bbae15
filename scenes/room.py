"""Rig and robots → one Pinocchio model of both arms, its bodies, and the pairs that can meet."""

from dataclasses import dataclass
from functools import cache

import coal
import numpy as np
import pinocchio as pin

from controllers.kinematics import Arm, Array
from scenes.rigs import RIGS, Rig
from scenes.robots import Capsule, Robot, lwr
from scenes.settings import ArmName, RigName

SIDES: tuple[ArmName, ArmName] = ("left", "right")


@dataclass(frozen=True)
class Room:
    """Everything about a place that does not change while it is used; shared by all who use it, so never write to it.

    Attributes:
        rig: where the arms stand.
        robots: left and right.
        model: both arms, left first (14 joints for two LWRs).
        geometry: their capsules, named "left hand" …, and the pairs.
        arms: left and right.
        start: q (nv,) [rad].
    """

    rig: Rig
    robots: tuple[Robot, Robot]
    model: pin.Model
    geometry: pin.GeometryModel
    arms: tuple[Arm, Arm]
    start: Array

    def arm(self, side: ArmName) -> Arm:
        """Return the arm of a side."""
        return self.arms[SIDES.index(side)]

    def other(self, side: ArmName) -> Arm:
        """Return the arm opposite a side."""
        return self.arms[1 - SIDES.index(side)]


@cache
def build_room(rig_name: RigName) -> Room:
    """Return the room of a rig with two LWRs, built once."""
    rig, robots = RIGS[rig_name], (lwr(), lwr())
    model, arms = pin.Model(), []
    for side, robot, base in zip(SIDES, robots, (rig.left_base, rig.right_base), strict=True):
        first = model.nv
        offset = model.njoints - 1
        model = pin.appendModel(model, _renamed(robot.model, side), 0, base)
        arms.append(
            Arm(
                side,
                slice(first, first + robot.model.nv),
                model.getFrameId(f"{side}_{robot.hand}"),
                robot.shoulder + offset,
                robot.elbow + offset,
                robot.wrist + offset,
                robot.labels,
            )
        )
    geometry = pin.GeometryModel()
    for side, robot, base, arm in zip(SIDES, robots, (rig.left_base, rig.right_base), arms, strict=True):
        offset = arm.shoulder - robot.shoulder
        for capsule in robot.capsules:
            placement = _capsule_placement(capsule)
            joint = capsule.joint + offset if capsule.joint else 0
            geometry.addGeometryObject(
                pin.GeometryObject(
                    f"{side} {capsule.name}",
                    joint,
                    placement if joint else base * placement,
                    coal.Capsule(capsule.radius, float(np.linalg.norm(capsule.end - capsule.start))),
                )
            )
    _add_pairs(geometry)
    return Room(rig, robots, model, geometry, (arms[0], arms[1]), np.concatenate([rig.left_start, rig.right_start]))


def _renamed(model: pin.Model, side: ArmName) -> pin.Model:
    model = model.copy()
    for i in range(1, model.njoints):
        model.names[i] = f"{side}_{model.names[i]}"
    for i in range(1, model.nframes):
        model.frames[i].name = f"{side}_{model.frames[i].name}"
    return model


def _capsule_placement(capsule: Capsule) -> pin.SE3:
    axis = capsule.end - capsule.start
    turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), axis / np.linalg.norm(axis)).toRotationMatrix()
    return pin.SE3(turn, (capsule.start + capsule.end) / 2.0)


def _add_pairs(geometry: pin.GeometryModel) -> None:
    """Pair every body of the left arm with every body of the right, but those whose distance no joint can change.

    Such a pair has J_d ≡ 0. Here that is fixed body against fixed body; a capsule about its own joint's axis would be another.
    """
    left = [i for i, body in enumerate(geometry.geometryObjects) if body.name.startswith("left ")]
    right = [i for i, body in enumerate(geometry.geometryObjects) if body.name.startswith("right ")]
    for a in left:
        for b in right:
            if geometry.geometryObjects[a].parentJoint or geometry.geometryObjects[b].parentJoint:
                geometry.addCollisionPair(pin.CollisionPair(a, b))
