"""What a server uses its processor time for."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any, Final

PARTS: Final[tuple[str, ...]] = ("step", "drawing", "packing", "sending")
"""Parts of the server's time; the rest is "other": asyncio, viser's windows, switches between threads."""


class ServerTimes:
    """Processor time of the server by part.

    Attributes:
        seconds: part → time so far [s].
        longest: longest frame since this was set to 0, with all that it called [s].
    """

    def __init__(self) -> None:
        self.seconds: dict[str, float] = dict.fromkeys(PARTS, 0.0)
        self.longest = 0.0
        self._open = threading.local()

    def timed(self, function: Callable[..., Any], part: str) -> Callable[..., Any]:
        """Return a function that adds its time to a part, without the time of the timed functions that it calls."""
        seconds, open_parts, clock = self.seconds, self._open, time.thread_time

        def call(*args: Any, **kwargs: Any) -> Any:
            around: float = getattr(open_parts, "inside", 0.0)
            open_parts.inside = 0.0
            begin = clock()
            try:
                return function(*args, **kwargs)
            finally:
                whole = clock() - begin
                seconds[part] += whole - open_parts.inside
                open_parts.inside = around + whole
                if part == "drawing":
                    self.longest = max(self.longest, whole)

        return call

    def watch(self) -> None:
        """Replace the functions of the program by timed ones, for the rest of the process."""
        from app.classroom.lecture import LectureHost
        from app.hosting.private_host import PrivateHost
        from app.session.session import Session
        from app.web import sending
        from app.web.connection import FilteredConnection

        for host in (PrivateHost, LectureHost):
            host.frame = self.timed(host.frame, "drawing")
        Session.step = self.timed(Session.step, "step")
        sending.pack = self.timed(sending.pack, "packing")
        FilteredConnection.send_data = self.timed(FilteredConnection.send_data, "sending")


def limit_of(figures: dict[str, float]) -> str:
    """Return a line with the parts of the server's time, the largest first; "" for figures without parts."""
    parts = {name: figures.get(f"{name}_percent") for name in (*PARTS, "other")}
    known = {name: value for name, value in parts.items() if value is not None}
    total = figures.get("cpu_percent_of_a_core", 0.0)
    if not known or total <= 0.0:
        return ""
    shares = sorted(known.items(), key=lambda entry: -entry[1])
    words = ", ".join(f"{name} {100.0 * value / total:.0f} %" for name, value in shares)
    return f"of {total:.0f} % of a core: {words}"
