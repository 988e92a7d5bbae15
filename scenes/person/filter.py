"""Filter of the robots' joint targets: a low-pass, a top speed, and a hold while no person is seen."""

import math
from typing import Final

import numpy as np

from controllers.kinematics import Array

CUTOFF: Final = 3.0
"""A person's gestures hold nothing faster; a camera's noise does [Hz]."""

TOP_RATE: Final = 1.6
"""Just below the slowest joint of an LWR, 100 °/s [rad/s]."""


class AngleFilter:
    """A first-order low-pass with an output that never turns faster than a top speed: every number y of it follows its input x by

        ẏ = clip(ω (x − y), ± top_rate),   ω = 2π cutoff,

    solved exactly for an input that rests during a step, so that two steps of dt/2 give what one of dt gives.

    Args:
        start: the output before the first step, any shape [rad].
        cutoff_hz: [Hz].
        top_rate: [rad/s].

    Attributes:
        values: the output, shaped like `start` [rad].
        rates: its mean speed during the last step [rad/s].
        lost: whether the last input was missing.
        lost_for: how long inputs have been missing [s].
    """

    def __init__(self, start: Array, cutoff_hz: float = CUTOFF, top_rate: float = TOP_RATE) -> None:
        self._omega, self._top_rate = math.tau * cutoff_hz, top_rate
        self.reset(start)

    def reset(self, start: Array) -> None:
        """Be at rest at these values, any shape [rad]."""
        self.values = np.array(start, float)
        self.rates = np.zeros_like(self.values)
        self.lost, self.lost_for = False, 0.0
        self._goal = self.values.copy()

    def step(self, wanted: Array | None, dt: float) -> Array:
        """Return the output after dt [s], a fresh array.

        Args:
            wanted: the input, shaped like `start` [rad]; None, or anything not finite, means that no person is seen: the output comes
                to rest at the input seen last.
        """
        self.lost = wanted is None or not bool(np.isfinite(wanted).all())
        if self.lost:
            self.lost_for += dt
        else:
            self.lost_for = 0.0
            self._goal[...] = wanted
        if dt > 0.0:
            values = self._goal - self._gap_after(self._goal - self.values, dt)
            self.rates = (values - self.values) / dt
            self.values = values
        return self.values.copy()

    def memory(self) -> tuple[Array, ...]:
        """Return everything that goes on to the next step, as copies: three arrays shaped like `start`, and a number ()."""
        return self.values.copy(), self.rates.copy(), self._goal.copy(), np.array(self.lost_for)

    def remember(self, memory: tuple[Array, ...]) -> None:
        self.values, self.rates, self._goal = (array.copy() for array in memory[:3])
        self.lost_for = float(memory[3])
        self.lost = self.lost_for > 0.0

    def _gap_after(self, gap: Array, dt: float) -> Array:
        knee = self._top_rate / self._omega
        size = np.abs(gap)
        straight = np.minimum(np.maximum(size - knee, 0.0) / self._top_rate, dt)
        left = (size - self._top_rate * straight) * np.exp(self._omega * (straight - dt))
        return np.copysign(left, gap)
