"""A visitor's newest entry wins over the server's writes.

Until an entry is acted upon, the server writes nothing into its control. Later writes carry the number of
handled messages; the page ignores those older than its last entry (`static/entries.js`).
"""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Generator
from contextvars import ContextVar
from dataclasses import dataclass


@dataclass
class _Entry:
    end: Callable[[], None]
    claimed: bool = False


_present: ContextVar[_Entry | None] = ContextVar("entry", default=None)


def claim_entry() -> Callable[[], None]:
    """Function that ends the present entry, if any."""
    entry = _present.get()
    if entry is None:
        return lambda: None
    entry.claimed = True
    return entry.end


class Entries:
    """Entries of one browser; from any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._dealt = 0
        self._waiting: dict[str, int] = {}

    def deal(self, count: int) -> None:
        """Record that the browser's first `count` messages are handled."""
        with self._lock:
            self._dealt = count

    @contextlib.contextmanager
    def taking(self, control: str, settle: Callable[[], None]) -> Generator[None]:
        """Context for a control's new value, which waits while it is claimed. `settle`: gives the control
        this value, overwriting later writes."""
        with self._lock:
            self._dealt += 1
            self._waiting[control] = number = self._dealt
        entry = _Entry(lambda: self._end(control, number, settle))
        token = _present.set(entry)
        try:
            yield
        finally:
            _present.reset(token)
            if not entry.claimed:
                entry.end()

    def _end(self, control: str, number: int, settle: Callable[[], None]) -> None:
        with self._lock:
            # A newer entry keeps waiting.
            if self._waiting.get(control) == number:
                del self._waiting[control]
                settle()

    def dealt_before(self, control: str) -> int | None:
        """Number of handled messages; None while an entry of the control waits."""
        with self._lock:
            return None if control in self._waiting else self._dealt
