"""Recorded answers of a custom law, and their replay."""

from bisect import bisect_right
from collections.abc import Sequence
from itertools import accumulate
from typing import NamedTuple

import numpy as np

from controllers.kinematics import Array
from controllers.laws.situation import Law, Situation
from scenes.simulation import Simulation


class LawAnswers(NamedTuple):
    """Answers of a custom law; read only.

    Attributes:
        file, sha256: name and hexadecimal hash of the file.
        rows: λ, and q̇ of the n = `Simulation.avoiding_joints` joints that avoid [rad/s] (steps, 1 + n).
    """

    file: str
    sha256: str
    rows: Array


class LawOfFile(Law):
    """A custom law, known by its answers only."""

    file: str
    sha256: str

    def activations(self, distances: Array) -> Array:
        """λ (k,) at distances (k,); nan if unknown."""
        return np.full(len(distances), np.nan)

    def line_rates(self, distances: Array, pull: float, approach: float, square: float) -> Array:
        """`Law.line_rate` (k,) [m/s] at distances (k,); nan if unknown."""
        del pull, approach, square
        return np.full(len(distances), np.nan)

    def line_rate(self, distance: float, pull: float, approach: float, square: float) -> float:
        """See `Law.line_rate` [m/s]; nan if unknown."""
        return float(self.line_rates(np.array([distance]), pull, approach, square)[0])


class ReplayedLaw(LawOfFile):
    """Repeats recorded answers, whatever the situation.

    Args:
        answers: of consecutive steps.
        simulation: its number of steps selects the answer.
        first: steps before the first answer.
    """

    def __init__(self, answers: Sequence[LawAnswers], simulation: Simulation, first: int) -> None:
        self.file, self.sha256, _ = answers[-1]
        self._rows = [part.rows for part in answers]
        self._starts = list(accumulate(map(len, self._rows), initial=first))
        self._simulation = simulation
        self._left: Array = np.empty(0)

    def activation(self, distance: float) -> float:
        """Recorded λ of this step; each `__call__` then gives q̇ of the next avoiding group."""
        del distance
        step = self._simulation.steps
        part = bisect_right(self._starts, step) - 1
        lam, self._left = np.split(self._rows[part][step - self._starts[part]], [1])
        return float(lam[0])

    def __call__(self, situation: Situation) -> Array:
        velocities, self._left = np.split(self._left, [len(situation.nominal)])
        return velocities
