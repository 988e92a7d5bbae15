"""The arm in a URDF file: its chain of joints as a Pinocchio model, and the landmarks on it."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Final
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin

from controllers.errors import BadInputFile, first_line
from controllers.kinematics import Array

if TYPE_CHECKING:
    import yourdfpy

FEWEST, MOST = 5, 7
"""Joints of an arm."""

GRIPPER: Final = ("gripper", "finger", "jaw")
"""Parts of the name of a joint that is no longer of the arm; it is held still."""

HANDS: Final = ("hand_tcp", "tcp", "tool0", "tool", "grasp", "ee_link", "end_effector", "eef")
"""Parts of the name of a hand frame; the first counts most."""

USUAL_SPEED: Final = 2.0
"""Of a joint without a speed limit [rad/s]."""

TURN: Final = 2.0 * np.pi
"""How far a joint without stops may turn to either side [rad]."""

SHOULDER_HEIGHT: Final = 0.31
"""Of the shoulder above the foot [m], as of the LWR; a lower one gets a column under its foot."""

SLOWEST: Final = 0.01
"""Least top speed of a joint [rad/s]."""

SHORTEST: Final = 0.1
LONGEST: Final = 10.0
"""Least and greatest length of an arm, from joint to joint [m]: beyond these its file is in other units."""

ROLL: Final = 0.8
"""Cosine of the angle between axis and link from which a joint only turns the link about itself."""


def find_chain(urdf: yourdfpy.URDF, name: str) -> tuple[str, ...]:
    """Return the names of the arm's joints, base first: the revolute ones from the root up to a fork, a gripper or the end.

    Args:
        name: of the file, for messages.

    Raises:
        BadInputFile: there is no chain of 5 to 7 revolute joints.
    """
    children: dict[str, list[yourdfpy.Joint]] = {}
    parents = [joint.child for joint in urdf.robot.joints]
    if len(set(parents)) != len(parents):
        raise BadInputFile("{name}: a link hangs on two joints; an arm is one chain.", name=name)
    for joint in urdf.robot.joints:
        children.setdefault(joint.parent, []).append(joint)
    roots = [link.name for link in urdf.robot.links if link.name not in set(parents)]
    if len(roots) != 1:
        raise BadInputFile("{name}: has {count} links without a parent; an arm has one, its base.", name=name, count=len(roots))
    chain: list[str] = []
    link = roots[0]
    while True:
        following = _movable(children, link)
        arm = [j for j in following if j.mimic is None and not any(part in j.name.lower() for part in GRIPPER)]
        complete = len(chain) >= FEWEST
        if not arm or (complete and (len(following) > 1 or arm[0].type not in ("revolute", "continuous"))):
            break
        if len(arm) > 1:
            raise BadInputFile(
                "{name}: forks into {joints} after {count} joints; give a file with one arm of 5 to 7 revolute joints in a chain.",
                name=name,
                joints=", ".join(_safe(j.name) for j in arm[:3]),
                count=len(chain),
            )
        (joint,) = arm
        if joint.type not in ("revolute", "continuous"):
            raise BadInputFile(
                "{name}: its joint {joint} is {kind}; Duet takes arms of 5 to 7 revolute joints.",
                name=name,
                joint=_safe(joint.name),
                kind=joint.type,
            )
        chain.append(joint.name)
        link = joint.child
    if not FEWEST <= len(chain) <= MOST:
        mimics = [j.name for j in _movable(children, link) if j.mimic is not None]
        if mimics:
            raise BadInputFile(
                "{name}: has {count} revolute joints in a chain, then {joint}, which only follows another (mimic); "
                "Duet takes arms of 5 to 7.",
                name=name,
                count=len(chain),
                joint=_safe(mimics[0]),
            )
        raise BadInputFile(
            "{name}: has {count} revolute joints in a chain; Duet takes arms of 5 to 7.", name=name, count=len(chain)
        )
    _check_joints([joint for joint in urdf.robot.joints if joint.name in chain], name)
    return tuple(chain)


def _check_joints(joints: list[yourdfpy.Joint], name: str) -> None:
    for joint in joints:
        limit, called = joint.limit, _safe(joint.name)
        if joint.type == "revolute":
            low, high = (np.nan, np.nan) if limit is None else (limit.lower, limit.upper)
            if low is None or high is None or not -np.inf < low < high < np.inf:
                raise BadInputFile("{name}: its joint {joint} has no limits between which it can move.", name=name, joint=called)
        speed = None if limit is None else limit.velocity
        if speed is not None and speed != 0.0 and not speed >= SLOWEST:
            raise BadInputFile(
                "{name}: its joint {joint} has a top speed of {speed} rad/s; give one from {least}, or none.",
                name=name,
                joint=called,
                speed=speed,
                least=SLOWEST,
            )
        if joint.axis is not None and not float(np.linalg.norm(joint.axis)) > 1e-6:
            raise BadInputFile("{name}: the axis of its joint {joint} is no direction.", name=name, joint=called)


def _movable(children: dict[str, list[yourdfpy.Joint]], link: str) -> list[yourdfpy.Joint]:
    """Return the next joints that are not fixed."""
    found: list[yourdfpy.Joint] = []
    waiting, seen = [link], {link}
    while waiting:
        for joint in children.get(waiting.pop(), ()):
            if joint.type != "fixed":
                found.append(joint)
            elif joint.child not in seen:
                seen.add(joint.child)
                waiting.append(joint.child)
    return found


def _safe(name: str) -> str:
    return "".join(c if c.isprintable() else "?" for c in name)[:40]


def chain_model(text: bytes, chain: tuple[str, ...], name: str) -> tuple[pin.Model, float]:
    """Return the model of the chain, all other joints held still, and the height of the column under its foot [m].

    Raises:
        BadInputFile: Pinocchio cannot read it.
    """
    robot = ElementTree.fromstring(text)
    for link in robot.iter("link"):
        for part in ("visual", "collision", "inertial"):
            for found in link.findall(part):
                link.remove(found)
    for joint in robot.findall("joint"):
        for found in joint.findall("mimic"):
            joint.remove(found)
        # Pinocchio cannot join models in which a joint and a link have the same name.
        if joint.get("name") not in chain:
            joint.set("type", "fixed")
            joint.set("name", f"fixed joint {joint.get('name')}")
            continue
        joint.set("name", f"arm_joint_{chain.index(str(joint.get('name'))) + 1}")
        limit = joint.find("limit")
        if limit is None:
            limit = ElementTree.SubElement(joint, "limit")
        if joint.get("type") == "continuous":
            joint.set("type", "revolute")
            limit.set("lower", str(-TURN))
            limit.set("upper", str(TURN))
        speed = float(limit.get("velocity", "0"))
        limit.set("velocity", str(speed if 0.0 < speed <= 10.0 else USUAL_SPEED))
        limit.set("effort", "1")
    try:
        model = pin.buildModelFromXML(ElementTree.tostring(robot, encoding="unicode"))
    except (ValueError, RuntimeError) as error:
        raise BadInputFile("{name}: is no URDF file ({reason}).", name=name, reason=first_line(error)) from None
    data = model.createData()
    axes = pin.computeJointJacobians(model, data, np.zeros(model.nq))[3:]
    _check_arm(data, axes, name)
    column = max(0.0, round(SHOULDER_HEIGHT - float(data.oMi[2].translation[2]), 3))
    if not column:
        return model, 0.0
    return pin.appendModel(pin.Model(), model, 0, pin.SE3(np.eye(3), np.array([0.0, 0.0, column]))), column


def _check_arm(data: pin.Data, axes: Array, name: str) -> None:
    """Refuse an arm in other units than metres, and one that can only move in a plane. `axes`: of the joints (3, n), as `data` has them."""
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
    """Return the joints at shoulder, elbow and wrist.

    The shoulder is the first joint across the first axis; the elbow is the one that changes the distance from there to the last joint
    most; the wrist is the next one that bends.
    """
    data, random = model.createData(), np.random.default_rng(2)
    stretch = np.zeros(model.njoints)
    bend = np.zeros(model.njoints)
    postures = random.uniform(-1.5, 1.5, (64, model.nq))
    last = model.njoints - 1
    axes = pin.computeJointJacobians(model, data, np.zeros(model.nq))[3:].T
    shoulder = next((j for j in range(2, last - 2) if np.linalg.norm(np.cross(axes[0], axes[j - 1])) > 0.5), 2)
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


def hand_frame(model: pin.Model) -> str:
    """Return the name of the hand's frame: one that is called so, else the farthest from the last joint."""
    last = model.njoints - 1
    frames = [frame for frame in model.frames if frame.parentJoint == last and frame.type == pin.FrameType.BODY]
    for part in HANDS:
        for frame in frames:
            if part in frame.name.lower():
                return frame.name
    return max(frames, key=lambda frame: float(np.linalg.norm(frame.placement.translation))).name
