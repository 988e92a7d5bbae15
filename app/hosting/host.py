"""What a server shows, and to whom."""

from typing import Protocol

from app.hosting.admission import Admission


class Host(Protocol):
    """Advances and draws what a server shows. `frame` belongs to the frame loop's thread."""

    admission: Admission

    def frame(self, now: float, elapsed: float) -> None:
        """Times are wall time, and time since the last frame [s]."""

    def close(self, goes_on: bool = False) -> None:
        """Save the visitors' work and close every session. `goes_on`: whether the next server continues it."""
