"""What is kept of a student's way through the lessons: progress that outlives a connection, and a run that can be done again."""

from collections.abc import Sequence
from dataclasses import dataclass

from app.settings import Settings
from scenes.targets import Target


@dataclass(frozen=True)
class Saved:
    """What outlives a connection.

    Attributes:
        progress: the walkthrough's JSON.
        own: the visitor's settings outside the lessons.
        open: whether a lesson was open.
    """

    progress: str
    own: Settings
    open: bool


class Again:
    """Somebody who does a recorded run again.

    Args:
        targets: one for every step.
        dt: of the steps [s].
    """

    def __init__(self, targets: Sequence[Target | None], dt: float) -> None:
        self._targets, self._dt = targets, dt

    def target(self, time: float) -> Target | None:
        """Return what was wanted then; at the end the last of it."""
        if not self._targets:
            return None
        return self._targets[min(max(round(time / self._dt), 0), len(self._targets) - 1)]
