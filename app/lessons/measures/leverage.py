"""Leverage: how well the joints can move the critical point along the line of contact, and what that costs."""

import numpy as np

from app.lessons.evidence import Evidence
from app.lessons.measures.distances import has_obstacle
from app.lessons.measures.quantity import Value, quantity


@quantity("|J_d| now", "m/rad", "m/rad", 3, live=True)
def lever_now(evidence: Evidence) -> Value:
    """Return |J_d| in the newest step [m/rad]."""
    return float(np.linalg.norm(evidence.lever(evidence.rows - 1))) if has_obstacle(evidence) else None


@quantity("smallest |J_d|", "m/rad", "m/rad", 3)
def smallest_lever(evidence: Evidence) -> Value:
    """Return the smallest |J_d| of the run [m/rad]."""
    if not has_obstacle(evidence):
        return None
    return float(np.linalg.norm(evidence.along(evidence.lever), axis=1).min())


@quantity("speed that the textbook's law asks for", "rad/s", "rad/s", 1)
def textbook_speed(evidence: Evidence) -> Value:
    """Return the largest λ v / |J_d| of the run, |q̇| by eq. (32) with the undamped J_d^# and a task at rest [rad/s]."""
    if not has_obstacle(evidence):
        return None
    levers = np.linalg.norm(evidence.along(evidence.lever), axis=1)
    asked = evidence.column("lambda")[evidence.sampled_rows()] * evidence.settings.law.nominal_velocity
    felt = levers > 1e-9
    return float((asked[felt] / levers[felt]).max()) if felt.any() else None


@quantity("largest joint speed reached", "rad/s", "rad/s", 2)
def reached_speed(evidence: Evidence) -> Value:
    """Return the largest speed of one joint [rad/s]."""
    return float(np.abs(evidence.velocities).max()) if evidence.rows else None


@quantity("largest share of a joint's top speed", "", "%", 0)
def speed_share(evidence: Evidence) -> Value:
    """Return the largest |q̇| of a joint over its limit."""
    return float((np.abs(evidence.velocities) / evidence.speed_limits).max()) if evidence.rows else None


@quantity("time without authority", "s", "s", 2)
def time_without_authority(evidence: Evidence) -> Value:
    """Return how long the arm could not do what the law asked for [s]."""
    return float(np.count_nonzero(evidence.column("authority"))) * evidence.settings.dt if evidence.rows else None
