"""Why a run stands still, in one place: every reason is set and lifted by its own author, and the run goes on when none is left."""

from collections.abc import Iterable
from typing import Final, Literal

Reason = Literal["visitor", "lesson", "replay", "class", "teacher", "hidden"]
"""The visitor pauses; the lesson waits for Run or has come to its end; a replay is shown; the teacher pauses the stage of a lecture;
the teacher pauses the visitor's own session; the visitor's tab is out of sight."""

NOT_THE_VISITORS: Final[frozenset[Reason]] = frozenset(("teacher", "hidden"))
"""Reasons that the visitor cannot lift."""


class Halt:
    """The reasons for which no step is made; false while there is none."""

    def __init__(self, reasons: Iterable[Reason] = ()) -> None:
        self._reasons: set[Reason] = set(reasons)

    def __bool__(self) -> bool:
        return bool(self._reasons)

    def __contains__(self, reason: Reason) -> bool:
        return reason in self._reasons

    def set(self, reason: Reason, halted: bool = True) -> None:
        """Set a reason, or lift it."""
        if halted:
            self._reasons.add(reason)
        else:
            self._reasons.discard(reason)

    def go_on(self) -> None:
        """Lift every reason that is the visitor's to lift."""
        self._reasons &= NOT_THE_VISITORS
