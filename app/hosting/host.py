"""What a server shows, and to whom."""

from typing import Protocol

from app.hosting.admission import Admission


class Host(Protocol):
    """Advances and draws what a server shows; `frame` belongs to the thread of the frame loop.

    Attributes:
        admission: of the browsers that come.
    """

    admission: Admission

    def frame(self, now: float, elapsed: float) -> None:
        """Advance and draw. `now`, `elapsed`: wall time, and that since the last frame [s]."""

    def close(self, goes_on: bool = False) -> None:
        """Keep what visitors have done, and close every session. `goes_on`: whether the next server goes on with it."""
