"""Everything that can be measured in a run, one subject a file."""

from app.lessons.measures import along, distance, following, hand, line, smoothness, tasks
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
    "line",
    "measure",
    "read_parameters",
    "shown_parameter",
    "shown_value",
    "smoothness",
    "tasks",
]
