"""The one thread that simulates and draws."""

import logging
import threading
import time
from collections.abc import Callable
from time import perf_counter
from typing import Final

from app.runtime.throttled_log import ThrottledLog
from app.web.client_buffer import waking_together

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
        note: called after every frame with the wall time that it took, and the time since the last one [s].
        clock: returns the wall time [s].
    """

    def __init__(
        self,
        frame: Callable[[float, float], None],
        due: threading.Event,
        note: Callable[[float, float], None] = lambda work, elapsed: None,
        clock: Callable[[], float] = perf_counter,
    ) -> None:
        self._frame, self._due, self._note, self._clock = frame, due, note, clock
        self._stopped = False
        self._began = self._beat = clock()
        self._errors = ThrottledLog(log)
        self._thread = threading.Thread(target=self._run, name="duet-frames", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def is_at_work(self) -> bool:
        return self._clock() - self._began < STUCK

    def stop(self) -> None:
        """Stop, and wait until the last frame is done."""
        self._stopped = True
        self._due.set()
        self._thread.join(timeout=5.0)

    def round(self) -> tuple[float, float]:
        """Make one frame; return before when there is no further one, and until when there is none unless it is asked for [s]."""
        now, last = self._clock(), self._began
        self._began = now
        try:
            with waking_together():
                self._frame(now, now - last)
        except Exception as error:
            self._errors.exception("a frame failed", error)
        self._note(self._clock() - now, now - last)
        if now >= self._beat:
            # After a late frame the beat starts again instead of catching up.
            self._beat = max(self._beat + FRAME, now + FRAME / 2.0)
        return now + SOONEST, self._beat

    def _run(self) -> None:
        while not self._stopped:
            self._due.clear()
            soonest, beat = self.round()
            time.sleep(max(soonest - self._clock(), 0.0))
            self._due.wait(max(beat - self._clock(), 0.0))
