"""Everything that can be measured in a run, one subject a file."""

from app.lessons.measures import contact_line as line
from app.lessons.measures import distances as distance
from app.lessons.measures import following
from app.lessons.measures import hand_errors as hand
from app.lessons.measures import late_robot as late
from app.lessons.measures import leverage as along
from app.lessons.measures import task_stability as tasks
from app.lessons.measures import velocity_jumps as smoothness
from app.lessons.measures.quantity import (
    QUANTITIES,
    Quantity,
    Value,
    checked_parameters,
    measure,
    read_parameters,
    shown_parameter,
    shown_value,
)

__all__ = [
    "QUANTITIES",
    "Quantity",
    "Value",
    "along",
    "checked_parameters",
    "distance",
    "following",
    "hand",
    "late",
    "line",
    "measure",
    "read_parameters",
    "shown_parameter",
    "shown_value",
    "smoothness",
    "tasks",
]
