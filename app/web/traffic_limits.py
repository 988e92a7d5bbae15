"""Limits of one browser: sizes, rates, memory, and places in queues."""

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
        text_bytes: of one field.
        upload_bytes: of a file, and of a browser's unfinished ones together.
        uploads: simultaneous files.
        messages_per_second: the rest is read later, which slows the sender down; a busy visitor sends about
            100.
        bytes_per_second: the same for their size.
        message_bytes: of a message that is not part of a file.
        frame_bytes: of a websocket message; viser's client cuts files into pieces of 512 kB.
        frames_waiting: queued websocket frames; the rest stays with the sender.
        small_frames_per_second: frames under 1 kB that end no message, such as pings; a connection that sends
            more is closed.
        connections: of one tab at once, and of one address for all pages without a tab's name.
        silent: of one address at once, without a place yet; a class, or all behind a proxy, may share it.
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
    """Token bucket, full at first.

    Args:
        per_second: rate at which it fills.
    """

    def __init__(self, per_second: float, most: float) -> None:
        self._per_second, self._most = per_second, most
        self._left, self._counted_at = 0.0, -math.inf

    def spend(self, cost: float, now: float | None = None) -> float:
        """Take `cost` out, also below zero. Returns the time until the bucket is back at zero [s]."""
        now = time.monotonic() if now is None else now
        self._left = min(self._most, self._left + (now - self._counted_at) * self._per_second) - cost
        self._counted_at = now
        return max(0.0, -self._left / self._per_second)


One = TypeVar("One")
Noted = TypeVar("Noted")


def remember(memory: dict[One, Noted], one: One, value: Noted, most: float) -> None:
    """Store a value as the newest, and drop the oldest above `most`."""
    memory.pop(one, None)
    memory[one] = value
    if len(memory) > most:
        del memory[next(iter(memory))]


class BoundedQueue(Generic[One]):
    """Queue with limits; iterates from the longest waiting on.

    Args:
        most: at once.
        of_address: from one address; a class, or all behind a proxy, may share it.
        of_tab: with the word of one tab.
    """

    def __init__(self, most: int, of_address: int, of_tab: int) -> None:
        self._most, self._of_address, self._of_tab = most, of_address, of_tab
        self._known: dict[One, tuple[str, str]] = {}

    def __iter__(self) -> Iterator[One]:
        return iter(tuple(self._known))

    def __len__(self) -> int:
        return len(self._known)

    def enter(self, one: One, address: str, word: str = "") -> One | None:
        """Add one, or update its word. `word`: "" while unknown.

        Returns:
            The one that has to leave: the oldest with the same word, from the same address or of all; None if
                there is room.
        """
        self._known[one] = address, word
        of_tab = [other for other, (_, its) in self._known.items() if word and its == word]
        of_address = [other for other, (its, _) in self._known.items() if its == address]
        for group, most in (
            (of_tab, self._of_tab),
            (of_address, self._of_address),
            ([*self._known], self._most),
        ):
            if len(group) > most:
                self.leave(group[0])
                return group[0]
        return None

    def leave(self, one: One) -> None:
        self._known.pop(one, None)
