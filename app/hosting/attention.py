"""When a page has its next frame: in every round while anything happens, seldom while it rests or its tab is out of sight."""

from typing import Final

LIVELY: Final = 3.0
"""So long after anything has happened, a page has a frame in every round: a camera may still be on its way [s]."""

RESTING: Final = 0.5
"""Time between two frames of a page on which nothing happens [s]."""

UNSEEN: Final = 1.0
"""Time between two frames of a page that is out of sight, so that a file it was asked for is still sent [s]."""


class Attention:
    """What one page has been doing lately. All times are wall time [s]."""

    def __init__(self) -> None:
        self._lively_until = self._next = 0.0
        self._hidden = self._paused = False
        self._state: object = None

    def due(self, now: float, hidden: bool, paused: bool, stirred: bool) -> bool:
        """Return whether a page has a frame in this round.

        Args:
            hidden: whether its tab is out of sight.
            paused: whether its run stands still.
            stirred: whether its browser has sent anything, or anything that it waited for has come, since the last frame.
        """
        turned = (hidden, paused) != (self._hidden, self._paused)
        self._hidden, self._paused = hidden, paused
        if stirred or turned:
            self._lively_until = now + LIVELY
        if not turned and now < self._next and (hidden or self.rests(now)):
            return False
        self._next = now + (UNSEEN if hidden else RESTING)
        return True

    def note(self, now: float, state: object) -> None:
        """Take note of a frame that was drawn. `state`: equal to the last one's if it reads the same."""
        if not self._paused or state != self._state:
            self._lively_until, self._state = now + LIVELY, state

    def rests(self, now: float) -> bool:
        """Return whether nothing has happened for a while."""
        return now >= self._lively_until
