"""Quantities, one subject a file; importing them fills `quantity.QUANTITIES`."""

from app.features.measures.quantities import distances

# isort: split
from app.features.measures.quantities import (
    contact_line,
    first_task_values,
    hand_errors,
    joint_speeds,
    postures,
    task_stability,
)

__all__ = [
    "contact_line",
    "distances",
    "first_task_values",
    "hand_errors",
    "joint_speeds",
    "postures",
    "task_stability",
]
