"""How near the obstacle came and how fast, what a robot that answers late makes of it, and how far arms are from joints they follow."""

import numpy as np

from app.lessons.evidence import Evidence
from app.lessons.measures.quantity import Row, Value, quantity
from controllers import budget
from controllers.kinematics import Array


@quantity("distance now", "m", "mm", 0, live=True, obstacle=True)
def distance_now(evidence: Evidence) -> Value:
    """Return d in the newest step [m]."""
    return float(evidence.column("d")[-1])


def _nearest(evidence: Evidence) -> Row:
    return int(evidence.column("d").argmin())


def _at(evidence: Evidence, time: float, **_: float) -> Row:
    return evidence.row_at(time)


@quantity("smallest distance", "m", "mm", 1, obstacle=True, row=_nearest)
def smallest_distance(evidence: Evidence) -> Value:
    """Return the smallest d of the run [m]."""
    return float(evidence.column("d").min())


@quantity("smallest d − dₘ", "m", "mm", 1, row=_nearest)
def distance_margin(evidence: Evidence) -> Value:
    """Return the smallest d of the run less d_m [m]; negative if the critical distance was passed."""
    smallest = smallest_distance(evidence)
    return None if smallest is None else smallest - evidence.settings.law.critical_distance


@quantity("distance lost of dₘ", "m", "mm", 1, row=_nearest)
def distance_lost(evidence: Evidence) -> Value:
    """Return by how much the smallest d of the run fell below d_m [m]; 0 if the critical distance was kept."""
    margin = distance_margin(evidence)
    return None if margin is None else max(-margin, 0.0)


@quantity("distance at {time}", "m", "mm", 1, obstacle=True, row=_at)
def distance_at(evidence: Evidence, time: float) -> Value:
    """Return d at a time [m]."""
    row = evidence.row_at(time)
    return float(evidence.column("d")[row]) if row is not None else None


@quantity("way made towards the obstacle", "m", "mm", 1, row=lambda evidence, since, until: evidence.row_at(until))
def way_made(evidence: Evidence, since: float, until: float) -> Value:
    """Return d(since) − d(until) [m]."""
    begin, end = distance_at(evidence, since), distance_at(evidence, until)
    return None if begin is None or end is None else begin - end


def _fastest(evidence: Evidence, within: float = 10.0) -> Row:
    return int(np.where(evidence.column("d") < within, evidence.column("w"), -np.inf).argmax())


@quantity("fastest approach of the obstacle", "m/s", "m/s", 2, obstacle=True, row=_fastest)
def largest_approach(evidence: Evidence, within: float = 10.0) -> Value:
    """Return the largest w while d was less than `within` [m/s]."""
    near = evidence.column("d") < within
    return float(evidence.column("w")[near].max()) if near.any() else None


@quantity("approach of the obstacle now", "m/s", "m/s", 2, live=True, obstacle=True)
def approach_now(evidence: Evidence) -> Value:
    """Return w in the newest step [m/s]."""
    return float(evidence.column("w")[-1])


@quantity("changes of the closest pair", "", "", 0, obstacle=True)
def pair_switches(evidence: Evidence) -> Value:
    """Return how often another pair of bodies became the closest."""
    return float(np.count_nonzero(np.diff(evidence.column("pair"))))


def _between(evidence: Evidence, since: float, until: float) -> np.ndarray:
    return (evidence.times >= since - 1e-9) & (evidence.times <= until + 1e-9)


def _nearest_between(evidence: Evidence, since: float, until: float) -> Row:
    return int(np.where(_between(evidence, since, until), evidence.column("d"), np.inf).argmin())


@quantity("swing of d, {since} to {until}", "m", "mm", 1, obstacle=True, row=_nearest_between)
def distance_swing(evidence: Evidence, since: float, until: float) -> Value:
    """Return the largest less the smallest d between two times [m]."""
    if evidence.row_at(until) is None:
        return None
    d = evidence.column("d")[_between(evidence, since, until)]
    return float(np.ptp(d)) if len(d) else None


@quantity("a T at {time}, T = {dead}", "", "", 2, obstacle=True, row=_at)
def dead_time_number(evidence: Evidence, time: float, dead: float) -> Value:
    """Return a T = n (u + w) T / d* with u and w of the step at a time, for a dead time T [s]: a rest is stable below π/2."""
    row = evidence.row_at(time)
    if row is None:
        return None
    law, u, w = evidence.settings.law, float(evidence.column("u")[row]), float(evidence.column("w_law")[row])
    v = law.nominal_velocity + (w if law.knows_w else 0.0)
    return dead / budget.settling_time(law.critical_distance, law.order, v, u, w)


def joint_errors(evidence: Evidence) -> Array:
    """Return |q_d − q| of the arm with the shown task (rows,) [rad]; nan, which does not tell, if it follows no joints."""
    return np.linalg.norm(evidence.desired - evidence.positions[:, evidence.arm.joints], axis=1)


@quantity("joint error now", "rad", "deg", 1, live=True)
def joint_error_now(evidence: Evidence) -> Value:
    """Return |q_d − q| in the newest step [rad]."""
    return float(joint_errors(evidence)[-1])


def _farthest_off(evidence: Evidence) -> Row:
    return int(joint_errors(evidence).argmax())


@quantity("largest joint error", "rad", "deg", 1, row=_farthest_off)
def largest_joint_error(evidence: Evidence) -> Value:
    """Return the largest |q_d − q| of the run [rad]."""
    return float(joint_errors(evidence).max())


def _first_within(evidence: Evidence, distance: float) -> Row:
    d = evidence.column("d")
    fallen = np.flatnonzero((d[1:] <= distance) & (d[:-1] > distance))
    return int(fallen[0]) + 1 if len(fallen) else None


@quantity("joint error when d fell to {distance}", "rad", "deg", 1, obstacle=True, row=_first_within)
def joint_error_met(evidence: Evidence, distance: float) -> Value:
    """Return |q_d − q| when d first fell to a distance [rad]."""
    row = _first_within(evidence, distance)
    return None if row is None else float(joint_errors(evidence)[row])


def _farthest_off_beyond(evidence: Evidence, distance: float) -> Row:
    beyond = evidence.column("d") > distance
    return int(np.where(beyond, joint_errors(evidence), -np.inf).argmax()) if beyond.any() else None


@quantity("largest joint error while d was more than {distance}", "rad", "deg", 1, obstacle=True, row=_farthest_off_beyond)
def joint_error_beyond(evidence: Evidence, distance: float) -> Value:
    """Return the largest |q_d − q| while d was more than a distance [rad]."""
    row = _farthest_off_beyond(evidence, distance)
    return None if row is None else float(joint_errors(evidence)[row])
