"""A robot arm as the rest of Duet sees it: one Pinocchio model, its capsules and its landmarks."""

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import pinocchio as pin

from controllers.kinematics import Array
from scenes.lwr import facts


@dataclass(frozen=True)
class Capsule:
    """A collision capsule of one arm.

    Attributes:
        name: part of the arm, as a person calls it.
        joint: index of the joint that carries it, 0 for the base.
        start, end: sphere centres (3,) in the frame of that joint [m].
        radius: [m].
    """

    name: str
    joint: int
    start: Array
    end: Array
    radius: float


@dataclass(frozen=True)
class Robot:
    """One arm.

    Attributes:
        name: of the make.
        model: the arm alone, base at the origin.
        hand: name of its hand frame.
        shoulder, elbow, wrist: indices of the joints whose origins are these points.
        capsules: its collision model, base first.
        labels: what a person calls each joint.
    """

    name: str
    model: pin.Model
    hand: str
    shoulder: int
    elbow: int
    wrist: int
    capsules: tuple[Capsule, ...]
    labels: tuple[str, ...]


@cache
def lwr() -> Robot:
    """Return the KUKA LWR 4+."""
    path = Path(__file__).parent / "lwr" / "lwr.urdf"
    capsules = tuple(
        Capsule(c.name, c.link, np.array([0.0, 0.0, c.start]), np.array([0.0, 0.0, c.end]), c.radius) for c in facts.CAPSULES
    )
    return Robot("KUKA LWR 4+", pin.buildModelFromUrdf(str(path)), "flange", 2, 4, 6, capsules, facts.JOINT_LABELS)
