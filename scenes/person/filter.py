"""Filter of the robots' joint targets: a low-pass, a top speed, and a hold while no person is seen."""

import math
from typing import Final

import numpy as np

from controllers.compiled import FilledMatrix, Loop, Matrix
from controllers.kinematics import Array

CUTOFF: Final = 3.0
"""A person's gestures hold nothing faster; a camera's noise does [Hz]."""

TOP_RATE: Final = 1.6
"""Just below the slowest joint of an LWR, 100 °/s [rad/s]."""


@Loop
def fill_filtered(goal: Matrix, omega: float, top_rate: float, dt: float, values: FilledMatrix, rates: FilledMatrix) -> None:
    """Bring values nearer to a goal, all (rows, k), and fill their mean speeds, see `AngleFilter`."""
    for i in range(goal.shape[0]):
        for j in range(goal.shape[1]):
            gap = goal[i, j] - values[i, j]
            size = abs(gap)
            straight = min(max(size - top_rate / omega, 0.0) / top_rate, dt)
            left = math.copysign((size - top_rate * straight) * math.exp(omega * (straight - dt)), gap)
            value = goal[i, j] - left
            rates[i, j] = (value - values[i, j]) / dt
            values[i, j] = value


class AngleFilter:
    """A first-order low-pass with an output that never turns faster than a top speed: every number y of it follows its input x by

        ẏ = clip(ω (x − y), ± top_rate),   ω = 2π cutoff,

    solved exactly for an input that rests during a step, so that two steps of dt/2 give what one of dt gives.

    Args:
        start: the output before the first step (rows, k) [rad].
        cutoff_hz: [Hz].
        top_rate: [rad/s].

    Attributes:
        values: the output, shaped like `start` [rad].
        rates: its mean speed during the last step [rad/s].
        lost_for: how long inputs have been missing [s].
    """

    def __init__(self, start: Array, cutoff_hz: float = CUTOFF, top_rate: float = TOP_RATE) -> None:
        self._omega, self._top_rate = math.tau * cutoff_hz, top_rate
        self.reset(start)

    def reset(self, start: Array) -> None:
        """Be at rest at these values (rows, k) [rad]."""
        self.values = np.array(start, float)
        self.rates = np.zeros_like(self.values)
        self.lost_for = 0.0
        self._goal = self.values.copy()

    def step(self, wanted: Array | None, dt: float) -> Array:
        """Return the output after dt > 0 [s], a fresh array.

        Args:
            wanted: the input, shaped like `start` [rad]; None, or anything not finite, means that no person is seen: the output comes
                to rest at the input seen last.
        """
        if wanted is None or not np.isfinite(wanted).all():
            self.lost_for += dt
        else:
            self.lost_for = 0.0
            self._goal[:] = wanted
        fill_filtered(self._goal, self._omega, self._top_rate, dt, self.values, self.rates)
        return self.values.copy()

    def memory(self) -> tuple[Array, ...]:
        """Return everything that goes on to the next step, as copies: three arrays shaped like `start`, and a number ()."""
        return self.values.copy(), self.rates.copy(), self._goal.copy(), np.array(self.lost_for)

    def remember(self, memory: tuple[Array, ...]) -> None:
        self.values, self.rates, self._goal = (array.copy() for array in memory[:3])
        self.lost_for = float(memory[3])
