"""What fails frame after frame, in the log: in full when it happens first, and then only how often, ever more rarely."""

import logging
from collections.abc import Callable
from dataclasses import dataclass
from time import monotonic
from typing import Final

INTERVALS: Final = (10.0, 60.0, 600.0)
"""Time from one line about the same thing to the next [s]; the last one stays."""


@dataclass
class _Known:
    said: float
    lines: int = 1
    unsaid: int = 0


class ThrottledLog:
    """Logs exceptions that may come thirty times a second.

    Args:
        log: where they are written.
        clock: returns the time [s].
    """

    def __init__(self, log: logging.Logger, clock: Callable[[], float] = monotonic) -> None:
        self._log, self._clock = log, clock
        self._known: dict[tuple[object, str, type[BaseException], str, int], _Known] = {}

    def tell(self, what: str, error: BaseException, whose: object = None) -> None:
        """Log what has failed, unless that was done lately.

        Args:
            what: the line; with the error's class and the place where it was raised it says which ones are the same.
            error: as it was caught.
            whose: session or browser; everybody's first is logged.
        """
        now, key = self._clock(), (whose, what, type(error), *_place(error))
        known = self._known.get(key)
        if known is None:
            self._known[key] = _Known(now)
            self._log.error(what, exc_info=error)
            return
        known.unsaid += 1
        since = now - known.said
        if since >= INTERVALS[min(known.lines, len(INTERVALS)) - 1]:
            self._log.error("%s: %d times more in %.0f s (%s)", what, known.unsaid, since, type(error).__name__)
            known.said, known.lines, known.unsaid = now, known.lines + 1, 0

    def forget(self, whose: object) -> None:
        """Somebody is gone; what happens to the next one is news."""
        for key in [key for key in self._known if key[0] == whose]:
            del self._known[key]


def _place(error: BaseException) -> tuple[str, int]:
    """Return file and line where an exception was raised; what it says may be another thing in every frame."""
    trace = error.__traceback__
    if trace is None:
        return "", 0
    while trace.tb_next is not None:
        trace = trace.tb_next
    return trace.tb_frame.f_code.co_filename, trace.tb_lineno
