"""What is asked of a session's run besides its settings."""

from dataclasses import dataclass


@dataclass
class RunLimits:
    """Limits that whatever leads a session sets, and takes back.

    Attributes:
        frame_ends_at: time of the run at which a frame ends, so that what comes then can be decided before the next step [s]; 0 without.
        on_grid: whether what the visitor holds is put on the grid of `scenes.run_text`, so that the run fits into a link.
        ghost_hidden: whether the ghost may not be seen yet: it plays against the visitor.
    """

    frame_ends_at: float = 0.0
    on_grid: bool = False
    ghost_hidden: bool = False
