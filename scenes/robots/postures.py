"""How each robot starts on each rig: clear of the other arm, elbow bent, hand in front, away from its own base, which cannot give way."""

from typing import Final

import numpy as np

from controllers.kinematics import Array
from scenes.rigs import RIGS
from scenes.settings import ArmName

# Degrees. The two of a torso mirror each other: the Panda's odd joints change sign (its hand sits 45° off, so that joint 7 mirrors
# about that), the UR5, with an arm that runs beside its foot, turns its base half round and folds the other way.
_POSTURES: Final[dict[tuple[str, str], dict[ArmName, tuple[float, ...]]]] = {
    ("panda", "torso"): {
        "left": (-44.0, -72.0, -85.0, -63.0, 25.0, 121.0, 48.0),
        "right": (44.0, -72.0, 85.0, -63.0, -25.0, 121.0, 42.0),
    },
    ("panda", "table"): {
        "left": (0.0, -28.0, 0.0, -90.0, 0.0, 62.0, 45.0),
        "right": (0.0, -28.0, 0.0, -90.0, 0.0, 62.0, 45.0),
    },
    ("ur5", "torso"): {
        "left": (-162.0, -54.0, 74.0, -23.0, 56.0, 0.0),
        "right": (-18.0, -126.0, -74.0, -157.0, -56.0, 0.0),
    },
    ("ur5", "table"): {
        "left": (-30.0, -115.0, 105.0, -80.0, -90.0, 0.0),
        "right": (-30.0, -115.0, 105.0, -80.0, -90.0, 0.0),
    },
}


def start_posture(robot_name: str, rig_name: str, side: ArmName) -> Array | None:
    """Return q (n,) [rad] in which an arm starts, a copy; None if none is known, see `scenes.robots.start_search`."""
    if rig_name not in ("torso", "table"):
        return None
    if robot_name == "lwr":
        rig = RIGS[rig_name]
        return (rig.left_start if side == "left" else rig.right_start).copy()
    known = _POSTURES.get((robot_name, rig_name))
    return None if known is None else np.radians(known[side])
