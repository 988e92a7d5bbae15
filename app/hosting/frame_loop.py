"""The one thread that simulates and draws."""

import logging
import threading
import time
from collections.abc import Callable
from time import perf_counter
from typing import Final, Protocol

from app.runtime.throttled_log import ThrottledLog

log = logging.getLogger("duet.hosts")

FRAME: Final = 1.0 / 32.0
"""Wall time of a frame [s]."""

SOONEST: Final = 0.008
"""Least wall time between two frames when what a visitor does asks for one at once [s]."""

STUCK: Final = 3.0
"""A frame that takes longer than this does not end any more, as far as a visitor can tell [s]."""


class Host(Protocol):
    """What is advanced and drawn.

    Attributes:
        wake: asks for a frame at once; set by the loop.
    """

    wake: Callable[[], None]

    def frame(self, now: float, elapsed: float) -> None:
        """Advance and draw. `now`: wall time [s]; `elapsed`: since the last frame [s]."""
        ...


class FrameLoop:
    """The one thread that simulates and draws: every `FRAME`, and at once (but not sooner than `SOONEST`) when it is woken.

    Args:
        host: what is advanced and drawn.
    """

    def __init__(self, host: Host) -> None:
        self._host = host
        self._stopped = False
        self._began = perf_counter()
        self._news = threading.Event()
        self._mishaps = ThrottledLog(log)
        self._thread = threading.Thread(target=self._run, name="duet-frames", daemon=True)
        host.wake = self._news.set

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def is_at_work(self) -> bool:
        """Return whether frames are being made."""
        return perf_counter() - self._began < STUCK

    def stop(self) -> None:
        """End, and wait until the last frame is done."""
        self._stopped = True
        self._news.set()
        self._thread.join(timeout=5.0)

    def _run(self) -> None:
        last = due = perf_counter()
        while not self._stopped:
            self._news.clear()
            now = self._began = perf_counter()
            try:
                self._host.frame(now, now - last)
            except Exception as error:
                self._mishaps.exception("a frame failed", error)
            last = now
            if now >= due:
                # After a late frame the beat starts anew instead of catching up.
                due = max(due + FRAME, now + FRAME / 2.0)
            time.sleep(max(now + SOONEST - perf_counter(), 0.0))
            self._news.wait(max(due - perf_counter(), 0.0))
