"""Hand and elbow, eqs (1)–(8)."""

import numpy as np
import pinocchio as pin

from app.features.measures.evidence import Evidence
from app.features.measures.quantities.quantity import At, Reading, Value, at, quantity
from app.features.measures.room_places import mark_places
from app.i18n.speaking import N_
from controllers.kinematics import Array, null_space_projector
from controllers.tasks import TASK_DIMENSION
from scenes.solo import LAP, circle


def hand_errors(evidence: Evidence) -> Array:
    """|e| (rows,) [m]; nan if the task is about joints."""
    if evidence.settings.experiment.error_unit != "m²":
        return np.full(evidence.rows, np.nan)
    return np.sqrt(evidence.column("e2"))


@quantity(N_("ways to move while the hand's task is kept"), "", 0, live=True)
def null_dimension(evidence: Evidence) -> Value:
    """trace (I − J^# J), eq. (6)."""
    J = evidence.kinematics_at(evidence.rows - 1).hand_jacobian(
        evidence.arm, TASK_DIMENSION[evidence.settings.task]
    )
    if np.linalg.matrix_rank(J, tol=1e-3) < len(J):
        return float(J.shape[1] - np.linalg.matrix_rank(J, tol=1e-3))
    return float(np.trace(null_space_projector(J)))


@quantity(N_("hand error"), "mm", 1, live=True)
def hand_error_now(evidence: Evidence) -> Value:
    return float(hand_errors(evidence)[-1])


@quantity(N_("largest hand error"), "mm", 2)
def largest_hand_error(evidence: Evidence, since: float = 0.0) -> Reading:
    errors, counted = hand_errors(evidence), evidence.times >= since - 1e-9
    return at(errors, int(np.where(counted, errors, -np.inf).argmax())) if counted.any() else None


@quantity(N_("mean hand error"), "mm", 1)
def mean_hand_error(evidence: Evidence) -> Value:
    return float(hand_errors(evidence).mean())


@quantity(N_("hand error at {time}"), "mm", 1)
def hand_error_at(evidence: Evidence, time: float) -> Reading:
    return at(hand_errors(evidence), evidence.row_at(time))


@quantity(N_("way between the elbow's farthest places"), "mm", 0)
def elbow_travel(evidence: Evidence) -> Reading:
    """At the row farthest from the first."""
    places = evidence.along(evidence.elbow)
    farthest = evidence.sampled_rows()[int(((places - places[0]) ** 2).sum(axis=1).argmax())]
    return At(max(float(np.sqrt(((places - place) ** 2).sum(axis=1).max())) for place in places), farthest)


@quantity(N_("largest turn of the hand"), "deg", 0)
def hand_turned(evidence: Evidence) -> Value:
    if not evidence.whole:
        return None
    first = evidence.kinematics_at(0).hand_pose(evidence.arm).rotation.copy()
    poses = (evidence.kinematics_at(row).hand_pose(evidence.arm) for row in evidence.sampled_rows())
    return max(float(np.linalg.norm(pin.log3(first.T @ pose.rotation))) for pose in poses)


@quantity(N_("elbow's smallest distance from the mark at {angle}"), "mm", 0)
def mark_miss(evidence: Evidence, angle: float) -> Value:
    """`angle`: about the line from shoulder to wrist [rad]."""
    (mark,) = mark_places(evidence.room, (angle,))
    return float(np.sqrt(((evidence.along(evidence.elbow) - mark) ** 2).sum(axis=1).min()))


def _last_lap(evidence: Evidence) -> tuple[int, int] | None:
    run = evidence.settings
    if not evidence.whole or not run.draws_circle:
        return None
    laps = int((float(evidence.times[-1]) + 0.25 * run.dt) / LAP)
    begin, end = evidence.row_at((laps - 1) * LAP), evidence.row_at(laps * LAP)
    return None if laps < 1 or begin is None or end is None else (begin, end)


@quantity(N_("drift of the tip in a lap"), "mm", 3)
def drift_per_lap(evidence: Evidence) -> Value:
    """|e(end) − e(begin)| of the last whole lap."""
    lap = _last_lap(evidence)
    if lap is None:
        return None
    home = evidence.hand(0)
    begin, end = (circle(float(evidence.times[row]), home)[0] - evidence.hand(row) for row in lap)
    return float(np.linalg.norm(end - begin))


@quantity(N_("drift of the joints in a lap"), "deg", 2)
def joint_drift_per_lap(evidence: Evidence) -> Value:
    """|q(end) − q(begin)| of the last whole lap."""
    lap = _last_lap(evidence)
    if lap is None:
        return None
    begin, end = (evidence.positions[row, evidence.arm.joints] for row in lap)
    return float(np.linalg.norm(end - begin))


@quantity(N_("largest hand error of the last lap"), "mm", 3)
def lap_error(evidence: Evidence) -> Reading:
    lap, errors = _last_lap(evidence), hand_errors(evidence)
    return None if lap is None else at(errors, lap[0] + int(errors[lap[0] : lap[1] + 1].argmax()))


@quantity(N_("K dt"), "", 2, live=True, settings=True)
def gain_step(evidence: Evidence) -> Value:
    """Above 2 the correction overshoots by more than the error."""
    run = evidence.settings
    return run.gain * (run.overdrive if "kx" in run.experiment.reads else 1.0) * run.dt
