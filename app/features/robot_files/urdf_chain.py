"""The arm as a Pinocchio model, with landmarks."""

from __future__ import annotations

from itertools import pairwise
from typing import Final
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin

from app.features.robot_files.joint_chain import MOST
from app.features.robot_files.urdf_tree import UrdfJoint, UrdfTree, short
from controllers.errors import BadInputFile, first_line
from controllers.kinematics import Array

HANDS: Final = ("hand_tcp", "tcp", "tool0", "tool", "grasp", "ee_link", "end_effector", "eef")
"""Parts of a hand frame's name, best first."""

COMPARED: Final = 3
"""Random postures in which both readers must agree."""

FASTEST: Final = 10.0
"""Greatest credible top speed [rad/s]."""

USUAL_SPEED: Final = 2.0
"""Default top speed of a joint [rad/s]."""

TURN: Final = 2.0 * np.pi
"""Bound of a joint without stops, to either side [rad]."""

SHOULDER_HEIGHT: Final = 0.31
"""Least height of the shoulder [m], the LWR's; a column adds the rest."""

SHORTEST: Final = 0.1
LONGEST: Final = 10.0
"""Length of an arm along its joints [m]; outside, the units are wrong."""

ROLL: Final = 0.8
"""Least cosine between axis and link of a joint that only turns the link."""


def frame_names(tree: UrdfTree) -> dict[str, str]:
    """Link → name of its frame: its own, unless it is taken."""
    taken = {
        "universe",
        *(f"arm_joint_{i}" for i in range(1, MOST + 1)),
        *(f"fixed joint {joint.name}" for joint in tree.joints),
    }
    names: dict[str, str] = {}
    for link in tree.links:
        called = link.name
        while called in taken or (called != link.name and any(called == other.name for other in tree.links)):
            called += " link"
        names[link.name] = called
        taken.add(called)
    return names


def chain_model(tree: UrdfTree, chain: tuple[str, ...], name: str) -> tuple[pin.Model, float]:
    """Model of the chain, other joints fixed, and height of its column [m].

    Raises:
        BadInputFile: Pinocchio cannot read it, or finds a different arm.
    """
    # Pinocchio gets nothing that it could reject: no shapes, no masses, our own names.
    robot = ElementTree.Element("robot", name="arm", version=tree.version)
    frames = frame_names(tree)
    for link in tree.links:
        ElementTree.SubElement(robot, "link", name=frames[link.name])
    for joint in tree.joints:
        turns = joint.name in chain
        called = f"arm_joint_{chain.index(joint.name) + 1}" if turns else f"fixed joint {joint.name}"
        part = ElementTree.SubElement(robot, "joint", name=called, type="revolute" if turns else "fixed")
        ElementTree.SubElement(part, "parent", link=frames[joint.parent])
        ElementTree.SubElement(part, "child", link=frames[joint.child])
        ElementTree.SubElement(part, "origin", joint.origin)
        if turns:
            ElementTree.SubElement(part, "axis", xyz=joint.direction)
            low, high = _stops(joint)
            ElementTree.SubElement(
                part, "limit", lower=repr(low), upper=repr(high), velocity=repr(top_speed(joint)), effort="1"
            )
    try:
        model = pin.buildModelFromXML(ElementTree.tostring(robot, encoding="unicode"))
    except (ValueError, RuntimeError) as error:
        raise BadInputFile(
            "{name}: is not a URDF file ({reason}).", name=name, reason=first_line(error)
        ) from None
    _check_placements(model, tree, chain, name)
    data = model.createData()
    axes = pin.computeJointJacobians(model, data, np.zeros(model.nq))[3:]
    _check_arm(data, axes, name)
    column = max(0.0, round(SHOULDER_HEIGHT - float(data.oMi[2].translation[2]), 3))
    if not column:
        return model, 0.0
    return pin.appendModel(pin.Model(), model, 0, pin.SE3(np.eye(3), np.array([0.0, 0.0, column]))), column


def _stops(joint: UrdfJoint) -> tuple[float, float]:
    """Bounds [rad]."""
    if joint.kind == "continuous" or joint.lower is None or joint.upper is None:
        return -TURN, TURN
    return joint.lower, joint.upper


def top_speed(joint: UrdfJoint) -> float:
    """[rad/s]; `USUAL_SPEED` if missing or not credible."""
    speed = joint.velocity or 0.0
    return speed if 0.0 < speed <= FASTEST else USUAL_SPEED


def link_poses(tree: UrdfTree, chain: tuple[str, ...], positions: Array) -> dict[str, Array]:
    """Link → pose (4, 4) in the root's frame; other joints at 0. `positions`: q (n,) of the chain [rad]."""
    from trimesh import transformations

    poses = {tree.root: np.eye(4)}
    waiting = list(tree.joints)
    while waiting:
        later = []
        for joint in waiting:
            if joint.parent not in poses:
                later.append(joint)
                continue
            pose = poses[joint.parent] @ joint.pose
            if joint.name in chain:
                pose = pose @ transformations.rotation_matrix(positions[chain.index(joint.name)], joint.axis)
            poses[joint.child] = pose
        waiting = later
    return poses


def _check_placements(model: pin.Model, tree: UrdfTree, chain: tuple[str, ...], name: str) -> None:
    data, random, frames = model.createData(), np.random.default_rng(3), frame_names(tree)
    for q in random.uniform(-np.pi, np.pi, (COMPARED, len(chain))):
        if model.nq != len(chain):
            break
        pin.framesForwardKinematics(model, data, q)
        for link, pose in link_poses(tree, chain, q).items():
            found = data.oMf[model.getFrameId(frames[link], pin.FrameType.BODY)].homogeneous
            # Relative to the position, for arms that are refused only later as far too large.
            if not np.allclose(found, pose, rtol=1e-6, atol=1e-6):
                raise BadInputFile(
                    f"{name}: two readers of URDF place its link {short(link)} differently; give its joints another way."
                )
    stops = np.array(
        [
            _stops(joint)
            for joint in sorted(
                (j for j in tree.joints if j.name in chain), key=lambda j: chain.index(j.name)
            )
        ]
    )
    if model.nq != len(chain) or not np.array_equal(
        stops.T, (model.lowerPositionLimit, model.upperPositionLimit)
    ):
        raise BadInputFile(
            f"{name}: two readers of URDF find different joints in it; give its joints another way."
        )


def _check_arm(data: pin.Data, axes: Array, name: str) -> None:
    """Refuse wrong units and planar arms. `axes`: (3, n)."""
    places = [placement.translation for placement in data.oMi[1:]]
    length = float(sum(np.linalg.norm(b - a) for a, b in pairwise(places)))
    if not SHORTEST <= length <= LONGEST:
        raise BadInputFile(
            "{name}: its joints are {length} m apart together; lengths in a URDF are in metres, and an arm has {least} to {most} m.",
            name=name,
            length=f"{length:.3g}",
            least=SHORTEST,
            most=LONGEST,
        )
    if np.linalg.matrix_rank(axes, tol=1e-3) < 2:
        raise BadInputFile("{name}: all its axes are parallel, so that its hand stays in a plane.", name=name)


def landmarks(model: pin.Model) -> tuple[int, int, int]:
    """Joints at shoulder, elbow and wrist.

    Shoulder: first joint across the first axis. Elbow: changes the distance from there to the last joint
    most. Wrist: the next one that bends.
    """
    data, random = model.createData(), np.random.default_rng(2)
    stretch = np.zeros(model.njoints)
    bend = np.zeros(model.njoints)
    postures = random.uniform(-1.5, 1.5, (64, model.nq))
    last = model.njoints - 1
    axes = pin.computeJointJacobians(model, data, np.zeros(model.nq))[3:].T
    shoulder = next(
        (j for j in range(2, last - 2) if np.linalg.norm(np.cross(axes[0], axes[j - 1])) > 0.5), 2
    )
    for q in postures:
        axes = pin.computeJointJacobians(model, data, q)[3:].T
        points = [data.oMi[j].translation.copy() for j in range(model.njoints)]
        way = points[last] - points[shoulder]
        way /= max(float(np.linalg.norm(way)), 1e-9)
        for j in range(shoulder + 1, last - 1):
            stretch[j] += abs(float(np.cross(axes[j - 1], points[last] - points[j]) @ way))
    elbow = int(np.argmax(stretch))
    for q in postures:
        axes = pin.computeJointJacobians(model, data, q)[3:].T
        for j in range(elbow + 1, model.njoints):
            link = data.oMi[j].translation - data.oMi[elbow].translation
            length = float(np.linalg.norm(link))
            bend[j] += abs(float(axes[j - 1] @ link)) / length if length > 1e-6 else 1.0
    wrist = next((j for j in range(elbow + 1, last) if bend[j] / len(postures) < ROLL), last - 1)
    return shoulder, elbow, wrist


def hand_frame(model: pin.Model) -> tuple[str, str]:
    """Frame of the hand, and the part of `HANDS` in its name; "" for the one farthest from the last joint."""
    last = model.njoints - 1
    frames = [
        frame for frame in model.frames if frame.parentJoint == last and frame.type == pin.FrameType.BODY
    ]
    for part in HANDS:
        for frame in frames:
            if part in frame.name.lower():
                return frame.name, part
    return max(frames, key=lambda frame: float(np.linalg.norm(frame.placement.translation))).name, ""
