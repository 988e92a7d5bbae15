"""What a visitor has entered in controls and nothing has acted upon yet: it wins over what the server writes there meanwhile.

Page and server both count the page's messages. Until an entry has been acted upon, the server writes nothing into its control; with what it
writes later it sends how many messages it had dealt with by then, and the page leaves out what is older than its own last entry
(`static/entries.js`).
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
    """Callback that ends the present entry, if any; the caller calls it when it acts upon the entry, or drops it."""
    entry = _present.get()
    if entry is None:
        return lambda: None
    entry.claimed = True
    return entry.end


class Entries:
    """The entries of one browser; may be used from any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._dealt = 0
        self._waiting: dict[str, int] = {}

    def deal(self, count: int) -> None:
        """Note that the first `count` messages of the browser have been dealt with: what they enter waits here, or has ended."""
        with self._lock:
            self._dealt = count

    @contextlib.contextmanager
    def taking(self, control: str, settle: Callable[[], None]) -> Generator[None]:
        """While open, the browser's next message is dealt with: a value for a control; it waits as long as it is claimed.

        Args:
            control: by which the page knows it.
            settle: gives the control this value on the server, whatever was written there meanwhile.
        """
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
            # A newer entry goes on waiting.
            if self._waiting.get(control) == number:
                del self._waiting[control]
                settle()

    def dealt_before(self, control: str) -> int | None:
        """Number of messages handled before what is written into a control now; None while an entry waits there."""
        with self._lock:
            return None if control in self._waiting else self._dealt
