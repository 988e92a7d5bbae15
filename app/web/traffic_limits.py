"""How much one browser may ask for: bounds, a rate, a memory that does not grow, and a queue that no single visitor fills."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Generic, TypeVar


@dataclass(frozen=True)
class TrafficLimits:
    """How much one browser may ask for.

    Attributes:
        text_bytes: longest text that may be typed into one field.
        upload_bytes: largest file, and the sum of all unfinished ones of a browser.
        uploads: files under way at the same time.
        messages_per_second: the rest is read later, which slows the sender down; a busy visitor sends about 100.
        bytes_per_second: the same for their size.
        message_bytes: largest message that is no part of a file.
        frame_bytes: largest single websocket message; viser's client cuts files into pieces of 512 kB.
        frames_waiting: websocket frames that are queued; the rest stays with the sender.
        small_frames_per_second: frames under 1 kB that end no message, such as pings; a connection that sends more is closed.
        connections: how many one tab may have at once, and one address for all pages without a tab's name.
        silent: how many one address may have at once that have no place yet; a class, or all that come through a proxy, may share it.
        first_message_seconds: a connection that sends nothing for this long after it opened is closed.
        stall_seconds: a browser that reads nothing for this long is disconnected.
    """

    text_bytes: int = 100_000
    upload_bytes: int = 20_000_000
    uploads: int = 4
    messages_per_second: float = 600.0
    bytes_per_second: float = 4_000_000.0
    message_bytes: int = 256_000
    frame_bytes: int = 1_000_000
    frames_waiting: int = 4
    small_frames_per_second: float = 100.0
    connections: int = 8
    silent: int = 300
    first_message_seconds: float = 10.0
    stall_seconds: float = 45.0


class Allowance:
    """A token bucket: it fills steadily, up to a bound.

    Args:
        per_second: how fast it fills.
        most: the bound; the bucket is full at first.
    """

    def __init__(self, per_second: float, most: float) -> None:
        self._per_second, self._most = per_second, most
        self._left, self._counted_at = 0.0, -math.inf

    def spend(self, cost: float, now: float | None = None) -> float:
        """Take `cost` out, also below zero; return the time until the bucket is back at zero [s]."""
        now = time.monotonic() if now is None else now
        self._left = min(self._most, self._left + (now - self._counted_at) * self._per_second) - cost
        self._counted_at = now
        return max(0.0, -self._left / self._per_second)


One = TypeVar("One")
Noted = TypeVar("Noted")


def remember(memory: dict[One, Noted], one: One, value: Noted, most: float) -> None:
    """Put a value into a memory as the newest one, and forget the oldest one of too many."""
    memory.pop(one, None)
    memory[one] = value
    if len(memory) > most:
        del memory[next(iter(memory))]


class BoundedQueue(Generic[One]):
    """Those that wait, the longest first. Iterating gives them in this order.

    Args:
        most: at once.
        of_address: at once from one address; a class, or all that come through a proxy, may share it.
        of_tab: at once with the word of one tab.
    """

    def __init__(self, most: int, of_address: int, of_tab: int) -> None:
        self._most, self._of_address, self._of_tab = most, of_address, of_tab
        self._known: dict[One, tuple[str, str]] = {}

    def __iter__(self) -> Iterator[One]:
        return iter(tuple(self._known))

    def __len__(self) -> int:
        return len(self._known)

    def enter(self, one: One, address: str, word: str = "") -> One | None:
        """Let one in, or take note of its word; return the one that has to leave: the oldest with the same word, from the same address
        or of all, None if there is room. `word`: "" as long as it is not known."""
        self._known[one] = address, word
        of_tab = [other for other, (_, its) in self._known.items() if word and its == word]
        of_address = [other for other, (its, _) in self._known.items() if its == address]
        for group, most in ((of_tab, self._of_tab), (of_address, self._of_address), ([*self._known], self._most)):
            if len(group) > most:
                self.leave(group[0])
                return group[0]
        return None

    def leave(self, one: One) -> None:
        """Forget one that waits no longer, or has not waited."""
        self._known.pop(one, None)
