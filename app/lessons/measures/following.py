"""Arms that follow joint angles: how far from them they are."""

import numpy as np

from app.lessons.evidence import Evidence
from app.lessons.measures.distances import has_obstacle
from app.lessons.measures.quantity import Value, quantity
from controllers.kinematics import Array


def joint_errors(evidence: Evidence) -> Array | None:
    """Return |q_d − q| of the arm with the shown task (rows,) [rad]; None if it follows no joints."""
    if not evidence.rows or np.isnan(evidence.desired[-1]).any():
        return None
    return np.linalg.norm(evidence.desired - evidence.positions[:, evidence.arm.joints], axis=1)


@quantity("joint error now", "rad", "deg", 1, live=True)
def joint_error_now(evidence: Evidence) -> Value:
    """Return |q_d − q| in the newest step [rad]."""
    errors = joint_errors(evidence)
    return None if errors is None else float(errors[-1])


@quantity("largest joint error", "rad", "deg", 1)
def largest_joint_error(evidence: Evidence) -> Value:
    """Return the largest |q_d − q| of the run [rad]."""
    errors = joint_errors(evidence)
    return None if errors is None else float(errors.max())


@quantity("joint error when d fell to {distance}", "rad", "deg", 1)
def joint_error_met(evidence: Evidence, distance: float) -> Value:
    """Return |q_d − q| when d first fell to a distance [rad]."""
    errors = joint_errors(evidence)
    if errors is None or not has_obstacle(evidence):
        return None
    d = evidence.column("d")
    fallen = np.flatnonzero((d[1:] <= distance) & (d[:-1] > distance))
    return float(errors[int(fallen[0]) + 1]) if len(fallen) else None


@quantity("largest joint error while d was more than {distance}", "rad", "deg", 1)
def joint_error_beyond(evidence: Evidence, distance: float) -> Value:
    """Return the largest |q_d − q| while d was more than a distance [rad]."""
    errors = joint_errors(evidence)
    if errors is None or not has_obstacle(evidence):
        return None
    beyond = evidence.column("d") > distance
    return float(errors[beyond].max()) if beyond.any() else None
