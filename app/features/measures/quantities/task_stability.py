"""Section III, eqs (14)–(25), with K_a = K."""

import numpy as np

from app.features.measures.evidence import Evidence
from app.features.measures.quantities.quantity import Value, quantity
from app.i18n.speaking import N_
from controllers.stability import Analysis, analyse
from controllers.tasks import TASK_DIMENSION

LOOKS = 60
"""Analysed moments of a run."""


def analysed(evidence: Evidence, row: int) -> Analysis:
    run = evidence.settings
    J_d = evidence.lever(row)
    J = None
    if run.experiment.error_unit == "m²":
        J = evidence.kinematics.hand_jacobian(evidence.arm, TASK_DIMENSION[run.task])
    return analyse(J_d, J, float(evidence.column("lambda")[row]), run.gain, run.gain, damped=True)


def _now(evidence: Evidence) -> Analysis:
    return analysed(evidence, evidence.rows - 1)


@quantity(N_("smallest eigenvalue of sym M"), "1/s", 2, live=True, obstacle=True)
def eigenvalue_now(evidence: Evidence) -> Value:
    """The paper's condition asks for more than 0."""
    return _now(evidence).smallest_eigenvalue


@quantity(N_("smallest eigenvalue of sym M in the run"), "1/s", 2, obstacle=True)
def least_eigenvalue(evidence: Evidence, since: float = 0.0) -> Value:
    rows = np.flatnonzero(evidence.times >= since - 1e-9)
    if not len(rows):
        return None
    chosen = rows[np.unique(np.linspace(0, len(rows) - 1, LOOKS).round().astype(int))]
    return min(analysed(evidence, int(row)).smallest_eigenvalue for row in chosen)


@quantity(N_("rank of both tasks together"), "", 0, live=True, obstacle=True)
def rank_now(evidence: Evidence) -> Value:
    """Eqs (14), (15)."""
    return float(_now(evidence).rank_stack)


@quantity(N_("1 − λρ², the part of the task that is left"), "", 2, live=True, obstacle=True)
def survival_now(evidence: Evidence) -> Value:
    return _now(evidence).survival


@quantity(N_("‖J_a J_b^#‖"), "", 2, live=True, obstacle=True)
def coupling_now(evidence: Evidence) -> Value:
    """Eq. (16): 0 for orthogonal tasks."""
    return _now(evidence).coupling
