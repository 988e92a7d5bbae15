"""Limits of one browser."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Generic, TypeVar


@dataclass(frozen=True)
class TrafficLimits:
    """What one browser may ask for.

    Attributes:
        text_bytes: of one field.
        upload_bytes: of all unfinished files together.
        messages_per_second: the rest is read later; a busy visitor sends about 100.
        bytes_per_second: likewise.
        message_bytes: of a message that is not part of a file.
        frame_bytes: of a websocket message; viser's client cuts files into pieces of 512 kB.
        frames_waiting: queued; the rest stays with the sender.
        small_frames_per_second: under 1 kB, without the end of a message, such as pings; more close the
            connection.
        connections: of one tab, and of one address for pages without a tab's name.
        silent: of one address without a place; a class, or all behind a proxy, may share it.
        head_seconds: then a connection without a complete request is closed.
        first_message_seconds: then a silent connection is closed.
        stall_seconds: then a browser that reads nothing is disconnected.
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
    head_seconds: float = 10.0
    first_message_seconds: float = 10.0
    stall_seconds: float = 45.0


class Allowance:
    """Token bucket, full at first; filled at `per_second`."""

    def __init__(self, per_second: float, most: float) -> None:
        self._per_second, self._most = per_second, most
        self._left, self._counted_at = 0.0, -math.inf

    def spend(self, cost: float, now: float | None = None) -> float:
        """Take `cost` out, also below zero. Returns the time until zero [s]."""
        now = time.monotonic() if now is None else now
        self._left = min(self._most, self._left + (now - self._counted_at) * self._per_second) - cost
        self._counted_at = now
        return max(0.0, -self._left / self._per_second)


One = TypeVar("One")
Noted = TypeVar("Noted")


def remember(memory: dict[One, Noted], one: One, value: Noted, most: float) -> None:
    """Store the newest value, and drop the oldest above `most`."""
    memory.pop(one, None)
    memory[one] = value
    if len(memory) > most:
        del memory[next(iter(memory))]


class BoundedQueue(Generic[One]):
    """Queue with limits in total, per address and per tab's word; iterates from the oldest."""

    def __init__(self, most: int, of_address: int, of_tab: int) -> None:
        self._most, self._of_address, self._of_tab = most, of_address, of_tab
        self._known: dict[One, tuple[str, str]] = {}

    def __iter__(self) -> Iterator[One]:
        return iter(tuple(self._known))

    def __len__(self) -> int:
        return len(self._known)

    def enter(self, one: One, address: str, word: str = "") -> One | None:
        """Add one, or update its word ("" while unknown).

        Returns:
            The oldest of the same word, of the same address or of all, if it has to leave; else None.
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
