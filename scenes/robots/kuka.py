"""The KUKA LWR 4+ of the paper, from our own numbers."""

import numpy as np
import pinocchio as pin

from scenes.lwr import facts
from scenes.lwr.urdf import FLANGE, URDF_FILE
from scenes.robots.description import Capsule, Robot


def build_lwr() -> Robot:
    """Return the KUKA LWR 4+."""
    capsules = tuple(
        Capsule(c.name, c.link, np.array([0.0, 0.0, c.start]), np.array([0.0, 0.0, c.end]), c.radius) for c in facts.CAPSULES
    )
    return Robot("KUKA LWR 4+", pin.buildModelFromUrdf(str(URDF_FILE)), FLANGE, 2, 4, 6, capsules, facts.JOINT_LABELS)
