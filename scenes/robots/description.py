"""Description of a robot arm."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from controllers.kinematics import Array


@dataclass(frozen=True)
class Capsule:
    """A collision capsule of one arm.

    Attributes:
        joint: index of its joint, 0 for the base.
        start, end: sphere centres (3,) in the frame of that joint [m]; never equal.
        radius: [m].
    """

    name: str
    joint: int
    start: Array
    end: Array
    radius: float


@dataclass(frozen=True)
class Robot:
    """One arm; all its joints are revolute and in one chain.

    Attributes:
        key: value of the setting `robot`.
        model: the arm alone, base at the origin.
        shoulder, elbow, wrist: indices of joints.
        capsules: collision model, base first.
        labels: display names of the joints.
    """

    key: str
    name: str
    model: pin.Model
    hand: str
    shoulder: int
    elbow: int
    wrist: int
    capsules: tuple[Capsule, ...]
    labels: tuple[str, ...]


def joint_axis(model: pin.Model, joint: int) -> Array:
    """Unit axis (3,) of a revolute joint, in its frame."""
    data = model.joints[joint].createData()
    model.joints[joint].calc(data, np.zeros(1))
    return np.array(data.S).reshape(-1)[3:]
