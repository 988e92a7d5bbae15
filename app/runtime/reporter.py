"""The network's lines in the log, so few that an attacker cannot fill it."""

from __future__ import annotations

import logging
import time

log = logging.getLogger("duet.server")


class Reporter:
    """Writes at most one line per kind and some seconds.

    Args:
        every: how many [s].
    """

    def __init__(self, every: float = 10.0) -> None:
        self._every = every
        self._last: dict[str, float] = {}
        self._held_back: dict[str, int] = {}

    def __call__(self, kind: str, detail: str) -> None:
        """Write what happened, or count it."""
        now = time.monotonic()
        if now - self._last.get(kind, -1e9) < self._every:
            self._held_back[kind] = self._held_back.get(kind, 0) + 1
            return
        self._last[kind] = now
        more = self._held_back.pop(kind, 0)
        log.warning("%s: %s%s", kind, detail, f" ({more} more since the last line)" if more else "")


class Forwarder(logging.Handler):
    """Turns the library's tracebacks (a stranger's garbage, a lost line) into one short line."""

    def __init__(self, report: Reporter) -> None:
        super().__init__()
        self._report = report

    def emit(self, record: logging.LogRecord) -> None:
        """Report a record."""
        error = record.exc_info[1] if record.exc_info else None
        self._report(record.getMessage()[:120], f"{type(error).__name__}: {error!s:.200}" if error else record.levelname.lower())
        log.debug(record.getMessage(), exc_info=record.exc_info)
