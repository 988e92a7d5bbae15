"""The thread that simulates and draws; resting and hidden pages have few frames."""

import logging
import threading
import time
from collections.abc import Callable
from time import perf_counter
from typing import Final

from app.runtime.throttled_log import ThrottledLog
from app.session.clock import FRAME
from app.web.sending import waking_together

log = logging.getLogger("duet.hosts")

SOONEST: Final = 0.008
"""Least time between frames [s]."""

STUCK: Final = 3.0
"""Time after which a frame may be stuck [s]."""

MOST_WORK, LONGEST = 15.0, 120.0
"""Most processor and wall time of a frame that is not stuck [s]."""


class FrameLoop:
    """Calls `frame` every `FRAME`, and at least `SOONEST` later when `due` is set. Times are wall times [s].

    Args:
        frame: given the time and the time since the last frame.
        note: called after it with its duration and the time since the last one.
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
        self._worked = self._seen = 0.0
        self._errors = ThrottledLog(log)
        self.thread = threading.Thread(target=self._run, name="duet-frames", daemon=True)

    def start(self) -> None:
        self.thread.start()

    def is_at_work(self) -> bool:
        return self._clock() - self._began < STUCK

    def hangs(self) -> bool:
        """True if the current frame is stuck, not merely slow: it neither works nor waits for a processor, or
        works too long. Call every few seconds.
        """
        worked, seen = _processor_time(self.thread), self._seen
        self._seen = worked
        if self.is_at_work():
            return False
        # Even a busy machine gives a thread that wants a processor one now and then.
        return worked == seen or worked - self._worked > MOST_WORK or self._clock() - self._began > LONGEST

    def stop(self) -> None:
        self._stopped = True
        self._due.set()
        self.thread.join(timeout=5.0)

    def round(self) -> tuple[float, float]:
        """Make one frame; earliest and latest time of the next one [s]."""
        now, last = self._clock(), self._began
        self._began, self._worked = now, _processor_time(self.thread)
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


def _processor_time(thread: threading.Thread) -> float:
    """Processor time of the thread or, if unknown, of the process [s]."""
    if thread.ident is None or not hasattr(time, "pthread_getcpuclockid"):
        return time.process_time()
    return time.clock_gettime(time.pthread_getcpuclockid(thread.ident))


LIVELY: Final = 3.0
"""Time with a frame in every round after an event: a camera may still move [s]."""

RESTING: Final = 0.5
"""Time between frames of a resting page [s]."""

UNSEEN: Final = 1.0
"""Time between frames of a hidden page, which still gets requested files [s]."""


class Attention:
    """Recent activity of one page; wall times [s]."""

    def __init__(self) -> None:
        self._lively_until = self._next = 0.0
        self._hidden = self._paused = False
        self._state: object = None

    def due(self, now: float, hidden: bool, paused: bool, dirty: bool) -> bool:
        """True if a page gets a frame in this round.

        `dirty`: the browser has sent anything, or a result has arrived, since the last frame.
        """
        turned = (hidden, paused) != (self._hidden, self._paused)
        self._hidden, self._paused = hidden, paused
        if dirty or turned:
            self._lively_until = now + LIVELY
        if not turned and now < self._next and (hidden or self.rests(now)):
            return False
        self._next = now + (UNSEEN if hidden else RESTING)
        return True

    def note(self, now: float, state: object) -> None:
        """Record a drawn frame; an equal `state` means no visible change."""
        if not self._paused or state != self._state:
            self._lively_until, self._state = now + LIVELY, state

    def rests(self, now: float) -> bool:
        return now >= self._lively_until
