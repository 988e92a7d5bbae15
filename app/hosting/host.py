"""What a server shows."""

from typing import Protocol

from app.hosting.admission import Admission


class Host(Protocol):
    """Advances and draws what a server shows."""

    admission: Admission

    def frame(self, now: float, elapsed: float) -> None:
        """Advance and draw, in the frame loop's thread.

        `now`: wall time, `elapsed`: since the last frame [s].
        """

    def close(self, goes_on: bool = False) -> None:
        """Save the visitors' work and close every session. `goes_on`: the next server continues it."""
