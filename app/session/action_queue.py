"""What a visitor asks for waits here for the next frame: one value a control, done for a bounded time a frame."""

import itertools
import logging
import threading
from collections import deque
from collections.abc import Callable, Hashable
from time import perf_counter
from typing import Final

log = logging.getLogger("duet.session")

Action = Callable[[], None]

BUDGET: Final = 0.010
"""Wall time in one frame after which what still waits is left for the next one [s]."""

MOST_REBUILDS: Final = 4
"""How often in `PERIOD` a session's page is built again, however often its visitor asks for it."""

PERIOD: Final = 1.0
"""[s]"""

MOST_PRESSES: Final = 64
"""Actions of no control that may wait; one more is left out."""


class ActionQueue:
    """Actions in the order in which they were asked for. `put` may be called from any thread, the rest from the session's only.

    Args:
        clock: returns the time [s].
    """

    def __init__(self, clock: Callable[[], float] = perf_counter) -> None:
        self._clock = clock
        self._lock = threading.Lock()
        self._waiting: dict[Hashable, Action] = {}
        self._presses = itertools.count()
        self._rebuilds: deque[float] = deque(maxlen=MOST_REBUILDS)
        self._rebuilding = False

    def __len__(self) -> int:
        return len(self._waiting)

    def put(self, action: Action, control: Hashable = None) -> None:
        """Have an action done.

        Args:
            action: what to do.
            control: what asks for it: its older action is dropped if it still waits. None for what counts every time, such as a step.
        """
        with self._lock:
            if control is None:
                if len(self._waiting) >= MOST_PRESSES:
                    return
                control = ("press", next(self._presses))
            # The newest goes to the end: what was asked for in between comes before it.
            self._waiting.pop(control, None)
            self._waiting[control] = action

    def rebuilt(self) -> None:
        """Note that the action which is being done has the page built again."""
        self._rebuilding = True

    def drop(self) -> None:
        with self._lock:
            self._waiting.clear()

    def do(self) -> None:
        """Do what waits, in order, until `BUDGET` is spent or the page was built again too often for one more time."""
        deadline = self._clock() + BUDGET
        # Which action builds is known only once it is done, so that none goes on where none may build.
        while self._may_rebuild() and (action := self._next()) is not None:
            self._rebuilding = False
            try:
                action()
            except Exception:
                # One visitor's odd input must not stop the clock of all.
                log.exception("an action of the page failed and was left out")
            now = self._clock()
            if self._rebuilding:
                self._rebuilds.append(now)
            if now >= deadline:
                return

    def _may_rebuild(self) -> bool:
        return len(self._rebuilds) < MOST_REBUILDS or self._clock() - self._rebuilds[0] >= PERIOD

    def _next(self) -> Action | None:
        with self._lock:
            first = next(iter(self._waiting), None)
            return None if first is None else self._waiting.pop(first)
