"""How each robot starts on each rig: clear of the other arm, elbow bent, hand in front where it can be led to the other one."""

from typing import Final

import numpy as np

from controllers.kinematics import Array
from scenes.rigs import RIGS
from scenes.settings import ArmName, RigName, RobotName

# Degrees. The two of a torso mirror each other: the Panda's odd joints change sign (its hand sits 45° off, so that joint 7 mirrors
# about that), the UR5, whose arm runs beside its foot, turns its base half round and folds the other way.
_POSTURES: Final[dict[tuple[RobotName, RigName], dict[ArmName, tuple[float, ...]]]] = {
    ("panda", "torso"): {
        "left": (-38.0, 43.0, -94.0, -133.0, -117.0, 142.0, 100.0),
        "right": (38.0, 43.0, 94.0, -133.0, 117.0, 142.0, -10.0),
    },
    ("panda", "table"): {
        "left": (0.0, -45.0, 0.0, -135.0, 0.0, 90.0, 45.0),
        "right": (0.0, -45.0, 0.0, -135.0, 0.0, 90.0, 45.0),
    },
    ("ur5", "torso"): {
        "left": (-148.0, -49.0, 106.0, 123.0, -87.0, 0.0),
        "right": (-32.0, -131.0, -106.0, 57.0, 87.0, 0.0),
    },
    ("ur5", "table"): {
        "left": (-30.0, -115.0, 105.0, -80.0, -90.0, 0.0),
        "right": (-30.0, -115.0, 105.0, -80.0, -90.0, 0.0),
    },
}


def start_posture(robot_name: RobotName, rig_name: RigName, side: ArmName) -> Array:
    """Return q (n,) [rad] in which an arm starts, a copy."""
    if robot_name == "lwr":
        rig = RIGS[rig_name]
        return (rig.left_start if side == "left" else rig.right_start).copy()
    return np.radians(_POSTURES[robot_name, rig_name][side])
