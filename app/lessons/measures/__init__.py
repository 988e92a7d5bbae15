"""Everything that can be measured in a run, one subject a file; importing them fills `quantity.QUANTITIES`."""

from app.lessons.measures import (
    contact_line,
    distances,
    following,
    hand_errors,
    late_robot,
    leverage,
    task_stability,
    velocity_jumps,
)

__all__ = ["contact_line", "distances", "following", "hand_errors", "late_robot", "leverage", "task_stability", "velocity_jumps"]
