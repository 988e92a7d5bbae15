"""A rate that may be exceeded for a moment."""

from __future__ import annotations

import math
import time


class Allowance:
    """What may be spent: it grows steadily, up to a bound.

    Args:
        per_second: how fast it grows.
        most: the bound, which is also what there is at first.
    """

    def __init__(self, per_second: float, most: float) -> None:
        self._per_second, self._most = per_second, most
        self._left, self._counted_at = 0.0, -math.inf

    def spend(self, cost: float, now: float | None = None) -> float:
        """Take `cost` off, at once even if there is less; returns in how many seconds what is missing will have grown [s]."""
        now = time.monotonic() if now is None else now
        self._left = min(self._most, self._left + (now - self._counted_at) * self._per_second) - cost
        self._counted_at = now
        return max(0.0, -self._left / self._per_second)
