"""A rate that may be exceeded for a moment."""

from __future__ import annotations

import math
import time


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
