"""A log of frequent events."""

import logging
from collections.abc import Callable
from dataclasses import dataclass
from time import monotonic
from traceback import walk_tb
from typing import Final

EVER_RARER: Final = (10.0, 60.0, 600.0)


@dataclass
class _Known:
    logged_at: float
    lines: int = 1
    events: int = 0


class ThrottledLog:
    """Logs a new event in full, then only its count.

    Args:
        intervals: shortest times between lines on one event [s]; the last one stays.
    """

    def __init__(
        self,
        log: logging.Logger,
        intervals: tuple[float, ...] = EVER_RARER,
        clock: Callable[[], float] = monotonic,
    ) -> None:
        self._log, self._intervals, self._clock = log, intervals, clock
        self._known: dict[tuple[object, ...], _Known] = {}

    def warning(self, kind: str, detail: str) -> None:
        """Log a line, unless one of this kind is recent."""
        due = self._due((None, kind))
        if due is not None:
            more = f" ({due[0] - 1} more since the last line)" if due[0] > 1 else ""
            self._log.warning("%s: %s%s", kind, detail, more)

    def exception(self, what: str, error: BaseException, source: object = None) -> None:
        """Log an exception: with its traceback if new, later only its count. Line, source, class and origin
        identify it.
        """
        due = self._due((source, what, type(error), *_place(error)))
        if due is None:
            return
        events, seconds = due
        if seconds == 0.0:
            self._log.error(what, exc_info=error)
        else:
            self._log.error("%s: %d times more in %.0f s (%s)", what, events, seconds, type(error).__name__)

    def forget(self, source: object) -> None:
        for key in [key for key in self._known if key[0] == source]:
            del self._known[key]

    def _due(self, key: tuple[object, ...]) -> tuple[int, float] | None:
        """Events since the last line and their time [s]; (1, 0.0) if new, None if no line is due."""
        now, known = self._clock(), self._known.get(key)
        if known is None:
            self._known[key] = _Known(now)
            return 1, 0.0
        known.events += 1
        since = now - known.logged_at
        if since < self._intervals[min(known.lines, len(self._intervals)) - 1]:
            return None
        self._known[key] = _Known(now, known.lines + 1)
        return known.events, since


def _place(error: BaseException) -> tuple[str, int]:
    """Origin of an exception, whose message may differ in every frame."""
    places = [(frame.f_code.co_filename, line) for frame, line in walk_tb(error.__traceback__)]
    return places[-1] if places else ("", 0)
