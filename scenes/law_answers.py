"""What a law of a file has answered, step by step, and the law that gives these answers again."""

from bisect import bisect_right
from collections.abc import Sequence
from itertools import accumulate
from typing import NamedTuple

import numpy as np

from controllers.kinematics import Array
from controllers.laws.situation import Law, Situation
from scenes.simulation import Simulation


class LawAnswers(NamedTuple):
    """The answers that a law of a file gave. The array is only to be read.

    Attributes:
        file, sha256: name of the file, and its hash in hexadecimal digits.
        rows: one a step (steps, 1 + n): λ, and q̇ of every joint that avoids [rad/s]; n by `Simulation.avoiding_joints`.
    """

    file: str
    sha256: str
    rows: Array


class LawOfFile(Law):
    """A law of a person's own file: known by its answers alone, not by settings.

    Attributes:
        file, sha256: as in `LawAnswers`.
    """

    file: str
    sha256: str

    def activations(self, distances: Array) -> Array:
        """Return λ (k,) at distances (k,) for a chart; nan where it is not known."""
        return np.full(len(distances), np.nan)

    def line_rates(self, distances: Array, pull: float, approach: float, square: float) -> Array:
        """Return J_d q̇ [m/s] (k,) at distances (k,) for a chart, see `Law.line_rate`; nan where it is not known."""
        del pull, approach, square
        return np.full(len(distances), np.nan)

    def line_rate(self, distance: float, pull: float, approach: float, square: float) -> float:
        """Return J_d q̇ [m/s] of an arm of which only one joint moves the distance, see `Law.line_rate`; nan where it is not known."""
        return float(self.line_rates(np.array([distance]), pull, approach, square)[0])


class ReplayedLaw(LawOfFile):
    """A law that gives recorded answers again, whatever it is asked.

    Args:
        answers: in order; their steps follow each other.
        simulation: whose law it is; the number of its steps decides which answers are given.
        first: number of steps before the first answer.
    """

    def __init__(self, answers: Sequence[LawAnswers], simulation: Simulation, first: int) -> None:
        self.file, self.sha256, _ = answers[-1]
        self._rows = [part.rows for part in answers]
        self._starts = list(accumulate(map(len, self._rows), initial=first))
        self._simulation = simulation
        self._left: Array = np.empty(0)

    def activation(self, distance: float) -> float:
        """Return the recorded λ of this step; after it, `__call__` gives q̇ of one avoiding group after the other."""
        del distance
        step = self._simulation.steps
        part = bisect_right(self._starts, step) - 1
        lam, self._left = np.split(self._rows[part][step - self._starts[part]], [1])
        return float(lam[0])

    def __call__(self, situation: Situation) -> Array:
        """Return the recorded q̇ (n,) [rad/s]."""
        velocities, self._left = np.split(self._left, [len(situation.nominal)])
        return velocities
