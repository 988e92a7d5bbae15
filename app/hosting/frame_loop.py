"""The one thread that simulates and draws."""

import logging
import threading
import time
from collections.abc import Callable
from time import perf_counter
from typing import Final

from app.runtime.throttled_log import ThrottledLog

log = logging.getLogger("duet.hosts")

FRAME: Final = 1.0 / 32.0
"""Wall time of a frame [s]."""

SOONEST: Final = 0.008
"""Least wall time between two frames when a visitor's action asks for one at once [s]."""

STUCK: Final = 3.0
"""A frame that takes longer than this counts as stuck [s]."""


class FrameLoop:
    """Calls a function every `FRAME`, and at once (but not sooner than `SOONEST`) when a frame is due.

    Args:
        frame: advances and draws everything, given the wall time and the time since the last frame [s].
        due: set to ask for a frame at once.
    """

    def __init__(self, frame: Callable[[float, float], None], due: threading.Event) -> None:
        self._frame, self._due = frame, due
        self._stopped = False
        self._began = perf_counter()
        self._errors = ThrottledLog(log)
        self._thread = threading.Thread(target=self._run, name="duet-frames", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def is_at_work(self) -> bool:
        return perf_counter() - self._began < STUCK

    def stop(self) -> None:
        """Stop, and wait until the last frame is done."""
        self._stopped = True
        self._due.set()
        self._thread.join(timeout=5.0)

    def _run(self) -> None:
        last = due = perf_counter()
        while not self._stopped:
            self._due.clear()
            now = self._began = perf_counter()
            try:
                self._frame(now, now - last)
            except Exception as error:
                self._errors.exception("a frame failed", error)
            last = now
            if now >= due:
                # After a late frame the beat starts again instead of catching up.
                due = max(due + FRAME, now + FRAME / 2.0)
            time.sleep(max(now + SOONEST - perf_counter(), 0.0))
            self._due.wait(max(due - perf_counter(), 0.0))
