"""Distance from the obstacle, and errors of followed joints."""

import numpy as np

from app.features.measures.evidence import Evidence
from app.features.measures.quantities.quantity import At, Reading, Value, at, quantity
from app.i18n.speaking import N_
from controllers import budget
from controllers.kinematics import Array


@quantity(N_("distance"), "mm", 0, live=True, obstacle=True)
def distance_now(evidence: Evidence) -> Value:
    return float(evidence.column("d")[-1])


@quantity(N_("smallest distance"), "mm", 1, obstacle=True)
def smallest_distance(evidence: Evidence) -> Reading:
    d = evidence.column("d")
    return at(d, int(d.argmin()))


@quantity(N_("smallest d − dₘ"), "mm", 1, obstacle=True)
def distance_margin(evidence: Evidence) -> Reading:
    d = evidence.column("d")
    return at(d - evidence.settings.law.critical_distance, int(d.argmin()))


@quantity(N_("distance lost of dₘ"), "mm", 1, obstacle=True)
def distance_lost(evidence: Evidence) -> Reading:
    d = evidence.column("d")
    return at(np.maximum(evidence.settings.law.critical_distance - d, 0.0), int(d.argmin()))


@quantity(N_("distance at {time}"), "mm", 1, obstacle=True)
def distance_at(evidence: Evidence, time: float) -> Reading:
    return at(evidence.column("d"), evidence.row_at(time))


@quantity(N_("way made towards the obstacle"), "mm", 1, obstacle=True)
def way_made(evidence: Evidence, since: float, until: float) -> Reading:
    begin, d = evidence.row_at(since), evidence.column("d")
    return None if begin is None else at(d[begin] - d, evidence.row_at(until))


@quantity(N_("fastest approach of the obstacle"), "m/s", 2, obstacle=True)
def largest_approach(evidence: Evidence, within: float = 10.0) -> Reading:
    near, w = evidence.column("d") < within, evidence.column("w")
    return at(w, int(np.where(near, w, -np.inf).argmax())) if near.any() else None


@quantity(N_("approach of the obstacle"), "m/s", 2, live=True, obstacle=True)
def approach_now(evidence: Evidence) -> Value:
    return float(evidence.column("w")[-1])


@quantity(N_("changes of the closest pair"), "", 0, obstacle=True)
def pair_switches(evidence: Evidence) -> Value:
    return float(np.count_nonzero(np.diff(evidence.column("pair"))))


@quantity(N_("swing of d, {since} to {until}"), "mm", 1, obstacle=True)
def distance_swing(evidence: Evidence, since: float, until: float) -> Reading:
    rows = np.flatnonzero((evidence.times >= since - 1e-9) & (evidence.times <= until + 1e-9))
    if evidence.row_at(until) is None or not len(rows):
        return None
    d = evidence.column("d")[rows]
    return At(float(np.ptp(d)), int(rows[d.argmin()]))


@quantity(N_("a T at {time}, T = {dead}"), "", 2, obstacle=True)
def dead_time_number(evidence: Evidence, time: float, dead: float) -> Reading:
    """a T = n (u + w) T / d* with u and w at `time`, `dead` T [s]: a rest is stable below π/2."""
    row = evidence.row_at(time)
    if row is None:
        return None
    law, u, w = evidence.settings.law, float(evidence.column("u")[row]), float(evidence.column("w_law")[row])
    v = law.nominal_velocity + (w if evidence.settings.adds_w else 0.0)
    return At(dead / budget.settling_time(law.critical_distance, law.order, v, u, w), row)


def joint_errors(evidence: Evidence) -> Array:
    """|q_d − q| (rows,) [rad]; nan if the arm follows no joints."""
    return np.linalg.norm(evidence.desired - evidence.positions[:, evidence.arm.joints], axis=1)


@quantity(N_("joint error"), "deg", 1, live=True)
def joint_error_now(evidence: Evidence) -> Value:
    return float(joint_errors(evidence)[-1])


@quantity(N_("largest joint error"), "deg", 1)
def largest_joint_error(evidence: Evidence) -> Reading:
    errors = joint_errors(evidence)
    return at(errors, int(errors.argmax()))


@quantity(N_("joint error when d fell to {distance}"), "deg", 1, obstacle=True)
def joint_error_met(evidence: Evidence, distance: float) -> Reading:
    d = evidence.column("d")
    fallen = np.flatnonzero((d[1:] <= distance) & (d[:-1] > distance))
    return at(joint_errors(evidence), int(fallen[0]) + 1) if len(fallen) else None


@quantity(N_("largest joint error while d was more than {distance}"), "deg", 1, obstacle=True)
def joint_error_beyond(evidence: Evidence, distance: float) -> Reading:
    errors, beyond = joint_errors(evidence), evidence.column("d") > distance
    return at(errors, int(np.where(beyond, errors, -np.inf).argmax())) if beyond.any() else None
