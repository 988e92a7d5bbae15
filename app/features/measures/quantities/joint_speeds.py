"""Lever and speeds of the joints."""

import numpy as np

from app.features.measures.evidence import Evidence
from app.features.measures.quantities.quantity import At, Reading, Row, Value, at, quantity
from app.i18n.speaking import N_
from controllers.kinematics import Array


@quantity(N_("|J_d|"), "m/rad", 3, live=True, obstacle=True)
def lever_now(evidence: Evidence) -> Value:
    return float(np.linalg.norm(evidence.lever(evidence.rows - 1)))


def _levers(evidence: Evidence) -> Array:
    return np.linalg.norm(evidence.along(evidence.lever), axis=1)


@quantity(N_("smallest |J_d|"), "m/rad", 3, obstacle=True)
def smallest_lever(evidence: Evidence) -> Reading:
    levers = _levers(evidence)
    return At(float(levers.min()), evidence.sampled_rows()[int(levers.argmin())])


@quantity(N_("speed that the textbook's law asks for"), "rad/s", 1, obstacle=True)
def textbook_speed(evidence: Evidence) -> Reading:
    """Largest λ v / |J_d|: |q̇| by eq. (32) with undamped J_d^# and a task at rest."""
    levers, rows = _levers(evidence), evidence.sampled_rows()
    asked = evidence.column("lambda")[rows] * evidence.settings.law.nominal_velocity
    speeds = np.divide(asked, levers, out=np.full(len(levers), -np.inf), where=levers > 1e-9)
    largest = int(speeds.argmax())
    return At(float(speeds[largest]), rows[largest]) if np.isfinite(speeds[largest]) else None


@quantity(N_("largest joint speed reached"), "rad/s", 2)
def reached_speed(evidence: Evidence) -> Reading:
    speeds = np.abs(evidence.velocities).max(axis=1)
    return at(speeds, int(speeds.argmax()))


@quantity(N_("largest share of a joint's top speed"), "%", 0)
def speed_share(evidence: Evidence) -> Reading:
    limits = evidence.room.model.velocityLimit[evidence.arm.joints]
    shares = (np.abs(evidence.velocities) / limits).max(axis=1)
    return at(shares, int(shares.argmax()))


@quantity(N_("time without authority"), "s", 2)
def time_without_authority(evidence: Evidence) -> Value:
    return float(np.count_nonzero(evidence.column("authority"))) * evidence.settings.dt


SWINGS = 4
"""Alternating steps that count as chatter."""


@quantity(N_("largest step of a joint's speed"), "rad/s", 3)
def velocity_step(evidence: Evidence) -> Reading:
    steps = np.abs(np.diff(evidence.velocities, axis=0)).max(axis=1)
    return At(float(steps.max()), int(steps.argmax()) + 1) if len(steps) else None


def _first_switch(evidence: Evidence) -> Row:
    """Row where λ first rises above ½."""
    lam = evidence.column("lambda")
    found = np.flatnonzero((lam[1:] > 0.5) & (lam[:-1] < 0.5))
    return int(found[0]) + 1 if len(found) else None


@quantity(N_("jump of the joint velocity"), "rad/s", 3)
def first_jump(evidence: Evidence) -> Reading:
    row = _first_switch(evidence)
    return (
        None
        if row is None
        else At(float(np.linalg.norm(evidence.velocities[row] - evidence.velocities[row - 1])), row)
    )


@quantity(N_("(v + u)/|J_d|"), "rad/s", 3)
def first_jump_formula(evidence: Evidence) -> Reading:
    row = _first_switch(evidence)
    if row is None:
        return None
    pull, lever = float(evidence.column("u")[row]), float(np.linalg.norm(evidence.lever(row)))
    return At((evidence.settings.law.nominal_velocity + pull) / lever, row) if lever else None


@quantity(N_("u at the switch"), "m/s", 3)
def switch_pull(evidence: Evidence) -> Reading:
    return at(evidence.column("u"), _first_switch(evidence))


@quantity(N_("|J_d| at the switch"), "m/rad", 3)
def switch_lever(evidence: Evidence) -> Reading:
    row = _first_switch(evidence)
    return None if row is None else At(float(np.linalg.norm(evidence.lever(row))), row)


def largest_zigzag(values: Array) -> tuple[float, Row]:
    """Largest alternating swing over `SWINGS` steps of values (k,), and row of its end; or 0 and None."""
    steps = np.diff(values)
    if len(steps) < SWINGS:
        return 0.0, None
    window = np.lib.stride_tricks.sliding_window_view(steps, SWINGS)
    turns = (window[:, 1:] * window[:, :-1] < 0.0).all(axis=1)
    swings = np.where(turns, np.abs(window).min(axis=1), 0.0)
    first = int(swings.argmax())
    return float(swings[first]), first + SWINGS if turns.any() else None


@quantity(N_("chatter of the distance"), "mm", 2, obstacle=True)
def zigzag(evidence: Evidence) -> Reading:
    swing, end = largest_zigzag(evidence.column("d"))
    return swing if end is None else At(swing, end)
