"""How well the joints can move the critical point along the line of contact, the speeds that this costs, their jumps, and chatter."""

import numpy as np

from app.lessons.evidence import Evidence
from app.lessons.measures.quantity import Row, Value, quantity
from controllers.kinematics import Array


@quantity("|J_d|", "m/rad", "m/rad", 3, live=True, obstacle=True)
def lever_now(evidence: Evidence) -> Value:
    """Return |J_d| in the newest step [m/rad]."""
    return float(np.linalg.norm(evidence.lever(evidence.rows - 1)))


def _levers(evidence: Evidence) -> Array:
    """Return |J_d| at the sampled rows (k,) [m/rad]."""
    return np.linalg.norm(evidence.along(evidence.lever), axis=1)


@quantity("smallest |J_d|", "m/rad", "m/rad", 3, obstacle=True, row=lambda e: e.sampled_rows()[int(_levers(e).argmin())])
def smallest_lever(evidence: Evidence) -> Value:
    """Return the smallest |J_d| of the run [m/rad]."""
    return float(_levers(evidence).min())


def _textbook_speeds(evidence: Evidence) -> Array:
    """Return λ v / |J_d| at the sampled rows (k,) [rad/s], −inf where J_d vanishes."""
    levers = _levers(evidence)
    asked = evidence.column("lambda")[evidence.sampled_rows()] * evidence.settings.law.nominal_velocity
    felt = levers > 1e-9
    return np.divide(asked, levers, out=np.full(len(levers), -np.inf), where=felt)


@quantity(
    "speed that the textbook's law asks for",
    "rad/s",
    "rad/s",
    1,
    obstacle=True,
    row=lambda evidence: evidence.sampled_rows()[int(_textbook_speeds(evidence).argmax())],
)
def textbook_speed(evidence: Evidence) -> Value:
    """Return the largest λ v / |J_d| of the run, |q̇| by eq. (32) with the undamped J_d^# and a task at rest [rad/s]."""
    largest = float(_textbook_speeds(evidence).max())
    return largest if np.isfinite(largest) else None


@quantity("largest joint speed reached", "rad/s", "rad/s", 2, row=lambda e: int(np.abs(e.velocities).max(axis=1).argmax()))
def reached_speed(evidence: Evidence) -> Value:
    """Return the largest speed of one joint [rad/s]."""
    return float(np.abs(evidence.velocities).max())


def _at_top_speed(evidence: Evidence) -> Row:
    return int((np.abs(evidence.velocities) / evidence.speed_limits).max(axis=1).argmax())


@quantity("largest share of a joint's top speed", "", "%", 0, row=_at_top_speed)
def speed_share(evidence: Evidence) -> Value:
    """Return the largest |q̇| of a joint over its limit."""
    return float((np.abs(evidence.velocities) / evidence.speed_limits).max())


@quantity("time without authority", "s", "s", 2)
def time_without_authority(evidence: Evidence) -> Value:
    """Return how long the arm could not do what the law asked for [s]."""
    return float(np.count_nonzero(evidence.column("authority"))) * evidence.settings.dt


SWINGS = 4
"""Steps in a row that go to and fro before that counts as chatter."""


def _largest_step(evidence: Evidence) -> Row:
    return int(np.abs(np.diff(evidence.velocities, axis=0)).max(axis=1).argmax()) + 1


@quantity("largest step of a joint's speed", "rad/s", "rad/s", 3, row=_largest_step)
def velocity_step(evidence: Evidence) -> Value:
    """Return the largest change of one joint's velocity from one step to the next [rad/s]."""
    return float(np.abs(np.diff(evidence.velocities, axis=0)).max()) if evidence.rows > 1 else None


def _first_switch(evidence: Evidence) -> Row:
    """Return the row in which avoidance is first switched on: λ was less than ½ the row before."""
    lam = evidence.column("lambda")
    found = np.flatnonzero((lam[1:] > 0.5) & (lam[:-1] < 0.5))
    return int(found[0]) + 1 if len(found) else None


@quantity("jump of the joint velocity", "rad/s", "rad/s", 3, row=_first_switch)
def first_jump(evidence: Evidence) -> Value:
    """Return |Δq̇| over all joints in the step in which avoidance is first switched on [rad/s]."""
    row = _first_switch(evidence)
    return None if row is None else float(np.linalg.norm(evidence.velocities[row] - evidence.velocities[row - 1]))


@quantity("(v + u)/|J_d|", "rad/s", "rad/s", 3, row=_first_switch)
def first_jump_formula(evidence: Evidence) -> Value:
    """Return (v + u)/|J_d| where avoidance is first switched on [rad/s]."""
    pull, lever = switch_pull(evidence), switch_lever(evidence)
    return None if pull is None or not lever else (evidence.settings.law.nominal_velocity + pull) / lever


@quantity("u at the switch", "m/s", "m/s", 3, row=_first_switch)
def switch_pull(evidence: Evidence) -> Value:
    """Return u where avoidance is first switched on [m/s]."""
    row = _first_switch(evidence)
    return None if row is None else float(evidence.column("u")[row])


@quantity("|J_d| at the switch", "m/rad", "m/rad", 3, row=_first_switch)
def switch_lever(evidence: Evidence) -> Value:
    """Return |J_d| where avoidance is first switched on [m/rad]."""
    row = _first_switch(evidence)
    return None if row is None else float(np.linalg.norm(evidence.lever(row)))


def largest_zigzag(values: Array) -> tuple[float, Row]:
    """Return the largest swing that values (k,) keep up to and fro for `SWINGS` steps, and where it ends; 0 and None if they never do."""
    steps = np.diff(values)
    if len(steps) < SWINGS:
        return 0.0, None
    window = np.lib.stride_tricks.sliding_window_view(steps, SWINGS)
    turns = (window[:, 1:] * window[:, :-1] < 0.0).all(axis=1)
    swings = np.where(turns, np.abs(window).min(axis=1), 0.0)
    first = int(swings.argmax())
    return float(swings[first]), first + SWINGS if turns.any() else None


@quantity("chatter of the distance", "m", "mm", 2, obstacle=True, row=lambda evidence: largest_zigzag(evidence.column("d"))[1])
def zigzag(evidence: Evidence) -> Value:
    """Return the largest swing of d to and fro from step to step, kept up for four steps [m]."""
    return largest_zigzag(evidence.column("d"))[0]
