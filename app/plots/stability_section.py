"""Section III for the run as it stands: what the panel on stability shows, or why it has nothing to say."""

from typing import Final

import numpy as np

from app.i18n.speaking import tr
from app.plots.stability_text import stability_html
from app.session.contact import Contact
from app.session.relevant_settings import both_avoid
from controllers.kinematics import Array
from controllers.stability import analyse, barrier
from controllers.tasks import TASK_DIMENSION, pose_error, position_error
from scenes.history import COLUMN, Sample
from scenes.simulation import Simulation

SPAN: Final = 0.3
"""The error's speed is measured over this time [s]."""


def section_html(simulation: Simulation, sample: Sample, now: Contact) -> str:
    """Return the panel, or one sentence on why there is none."""
    run, law = simulation.settings, simulation.settings.law
    if law.law not in ("smooth_priority", "unprotected"):
        return _nothing("Section III is about eq. (12). Of this law it says nothing; take smooth priority to see it.")
    if law.coupled and both_avoid(run):
        return _nothing("Section III is about one arm and its task; here one row is shared by both arms.")
    error, J = task_error(simulation, sample)
    gain = run.gain
    analysis = analyse(now.row, J, sample.activation, gain, gain, damped=True)
    speed = law.nominal_velocity + (now.approach if law.feed_forward else 0.0)
    e = analysis.error(speed, error)
    W = None
    if J is None and law.law == "smooth_priority":
        W = barrier(error, gain, now.row, now.distance, law.critical_distance, law.order, law.nominal_velocity)
    return stability_html(analysis, sample.error, error_rate(simulation), analysis.lyapunov(e), analysis.lyapunov_rate(e), W)


def task_error(simulation: Simulation, sample: Sample) -> tuple[Array, Array | None]:
    """Return e_b (m,) of the task shown [m, rad] and its Jacobian J_b (m, n), None for joints."""
    arm, place, rotation = simulation.avoiding, simulation.place, simulation.place_rotation
    if place is None or rotation is None:
        return sample.desired[arm.joints] - sample.positions[arm.joints], None
    pose = simulation.kinematics.hand_pose(arm)
    J = simulation.roles.task.task_jacobian
    if J is None:
        # Nothing was asked of the hand yet.
        J = simulation.kinematics.hand_jacobian(arm)[: TASK_DIMENSION[simulation.settings.task]]
    return position_error(pose, place) if len(J) == 3 else pose_error(pose, place, rotation), J


def error_rate(simulation: Simulation) -> float:
    """Return how fast |e| has changed lately [m/s or rad/s]; nan before the second step."""
    table = simulation.history.table(round(SPAN / simulation.settings.dt) + 1)
    if len(table) < 2:
        return float("nan")
    first, last = table[0], table[-1]
    change = np.sqrt(last[COLUMN["e2"]]) - np.sqrt(first[COLUMN["e2"]])
    return float(change / (last[COLUMN["t"]] - first[COLUMN["t"]]))


def _nothing(sentence: str) -> str:
    return f'<div class="duet duet-stability"><p>{tr(sentence)}</p></div>'
