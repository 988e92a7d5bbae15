"""The arm among a URDF file's joints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from app.features.robot_files.urdf_tree import UrdfJoint, UrdfTree, short
from controllers.errors import BadInputFile

FEWEST, MOST = 5, 7
"""Joints of an arm."""

GRIPPER: Final = ("gripper", "finger", "jaw")
"""Parts of names of joints beyond the arm; these are held still."""

TURNING: Final = ("revolute", "continuous")

MOST_NAMES: Final = 60

FARTHEST: Final = 50.0
"""Greatest bound [rad]: a larger one is in degrees, or means no stops."""

SLOWEST: Final = 0.01
"""Least top speed [rad/s]."""


@dataclass(frozen=True)
class Chain:
    """Joints of the arm, base first, and other movable ones.

    Attributes:
        hand: its link; "" leaves the choice to `hand_frame`.
    """

    joints: tuple[str, ...]
    hand: str
    still: tuple[str, ...]


def find_chain(tree: UrdfTree, name: str, hand: str = "") -> Chain:
    """Revolute joints from the root to the hand, or up to a fork, a gripper or the end.

    Raises:
        BadInputFile: no chain of 5 to 7 revolute joints, or no such link.
    """
    joints = _joints_to(tree, hand, name) if hand else _joints_from_root(tree, name)
    _check_joints(joints, name)
    chain = tuple(joint.name for joint in joints)
    still = (joint.name for joint in tree.joints if joint.kind != "fixed" and joint.name not in chain)
    return Chain(chain, hand, tuple(still))


def _joints_to(tree: UrdfTree, hand: str, name: str) -> list[UrdfJoint]:
    links = [link.name for link in tree.links]
    if hand not in links:
        known = ", ".join(map(short, links[:MOST_NAMES])) + ("" if len(links) <= MOST_NAMES else ", …")
        raise BadInputFile(
            f"{name}: has no link {short(hand)} that could be the hand; its links are {known}."
        )
    above = {joint.child: joint for joint in tree.joints}
    way: list[UrdfJoint] = []
    link = hand
    while link in above:
        way.insert(0, above[link])
        link = above[link].parent
    moving = [joint for joint in way if joint.kind != "fixed"]
    for joint in moving:
        if joint.kind not in TURNING or joint.mimic:
            kind = "only follows another (mimic)" if joint.mimic else f"is {joint.kind}"
            raise BadInputFile(
                f"{name}: on the way to the hand {short(hand)}, its joint {short(joint.name)} {kind}; "
                f"Duet takes arms of {FEWEST} to {MOST} revolute joints."
            )
    if not FEWEST <= len(moving) <= MOST:
        raise BadInputFile(
            f"{name}: has {len(moving)} revolute joints on the way to the hand {short(hand)}; Duet takes arms of {FEWEST} to {MOST}."
        )
    return moving


def _joints_from_root(tree: UrdfTree, name: str) -> list[UrdfJoint]:
    children: dict[str, list[UrdfJoint]] = {}
    for joint in tree.joints:
        children.setdefault(joint.parent, []).append(joint)
    chain: list[UrdfJoint] = []
    link = tree.root
    while True:
        following = _movable(children, link)
        arm = [j for j in following if not j.mimic and not any(part in j.name.lower() for part in GRIPPER)]
        complete = len(chain) >= FEWEST
        if not arm or (complete and (len(following) > 1 or arm[0].kind not in TURNING)):
            break
        if len(arm) > 1:
            raise BadInputFile(
                "{name}: forks into {joints} after {count} joints; give a file with one arm of 5 to 7 revolute joints in a chain, "
                "or name the hand with --hand-left or --hand-right.",
                name=name,
                joints=", ".join(short(joint.name) for joint in arm[:3]),
                count=len(chain),
            )
        (joint,) = arm
        if joint.kind not in TURNING:
            raise BadInputFile(
                "{name}: its joint {joint} is {kind}; Duet takes arms of 5 to 7 revolute joints.",
                name=name,
                joint=short(joint.name),
                kind=joint.kind,
            )
        chain.append(joint)
        link = joint.child
    if not FEWEST <= len(chain) <= MOST:
        mimics = [j.name for j in _movable(children, link) if j.mimic]
        if mimics:
            raise BadInputFile(
                "{name}: has {count} revolute joints in a chain, then {joint}, which only follows another (mimic); "
                "Duet takes arms of 5 to 7.",
                name=name,
                count=len(chain),
                joint=short(mimics[0]),
            )
        raise BadInputFile(
            "{name}: has {count} revolute joints in a chain; Duet takes arms of 5 to 7.",
            name=name,
            count=len(chain),
        )
    return chain


def _check_joints(joints: list[UrdfJoint], name: str) -> None:
    for joint in joints:
        low, high, speed, called = joint.lower, joint.upper, joint.velocity, short(joint.name)
        if joint.kind == "revolute":
            # The format takes 0 for a missing bound, which is hardly ever meant.
            missing = [key for key, bound in (("lower", low), ("upper", high)) if bound is None]
            if len(missing) == 1:
                raise BadInputFile(
                    f"{name}: the limit of its joint {called} has no {missing[0]}; give lower and upper [rad]."
                )
            if low is None or high is None or not -np.inf < low < high < np.inf:
                raise BadInputFile(
                    "{name}: its joint {joint} has no limits between which it can move.",
                    name=name,
                    joint=called,
                )
            if max(-low, high) > FARTHEST:
                raise BadInputFile(
                    f"{name}: its joint {called} turns from {low:g} to {high:g} rad, many times round; limits in a URDF are in "
                    "radians (180° are 3.1416), and a joint without stops is of the type continuous."
                )
        if speed is not None and speed != 0.0 and not speed >= SLOWEST:
            raise BadInputFile(
                "{name}: its joint {joint} has a top speed of {speed} rad/s; give one from {least}, or none.",
                name=name,
                joint=called,
                speed=speed,
                least=SLOWEST,
            )
        if not float(np.linalg.norm(joint.axis)) > 1e-6:
            raise BadInputFile(
                "{name}: the axis of its joint {joint} is not a direction.", name=name, joint=called
            )


def _movable(children: dict[str, list[UrdfJoint]], link: str) -> list[UrdfJoint]:
    found: list[UrdfJoint] = []
    waiting = [link]
    while waiting:
        for joint in children.get(waiting.pop(), ()):
            if joint.kind != "fixed":
                found.append(joint)
            else:
                waiting.append(joint.child)
    return found
