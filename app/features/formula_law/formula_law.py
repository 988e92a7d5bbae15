"""The law of a formula: q̇ = q̇_n + J_d^# c, with the change c of the distance rate [m/s]."""

import hashlib
from collections.abc import Callable, Sequence
from typing import Final

import numpy as np

from app.features.custom_law.law_limits import LawProblem, problem_of
from app.features.formula_law.formula import Formula
from controllers.errors import LazyText, NumberText
from controllers.kinematics import Array
from controllers.laws.situation import Situation, along_row
from scenes.law_answers import LawOfFile
from scenes.settings import LawSettings

FILE: Final = LazyText("formula")

LARGEST: Final = 1e6
"""Largest |c| [m/s], so that q̇ is finite."""


class FormulaLaw(LawOfFile):
    """A visitor's formula as a law, computed in the server's process.

    Where the formula is not defined, the arm freezes and `problem` gives the reason.

    Args:
        formula: gives c [m/s].
        settings: gives d_m, n and v.
    """

    def __init__(self, formula: Formula, settings: Callable[[], LawSettings]) -> None:
        self.formula = formula
        self.file: str = FILE
        self.sha256 = hashlib.sha256(formula.text.encode("utf-8", "replace")).hexdigest()
        self.problem: LawProblem | None = None
        self._settings = settings

    def __call__(self, situation: Situation) -> Array:
        if self.problem is None:
            try:
                change = self.change(situation.distance, situation.pull, situation.approach)
            except (ArithmeticError, ValueError) as error:
                self._fail(error, situation)
            else:
                return along_row(situation.nominal, situation.row, change)
        return np.zeros(len(situation.nominal))

    def change(self, distance: float, pull: float, approach: float) -> float:
        """c [m/s] at d [m], u and w [m/s].

        Raises:
            ArithmeticError, ValueError: not defined there.
        """
        value = self.formula.value(self._values(float(distance), float(pull), float(approach)))
        if not abs(value) <= LARGEST:
            raise OverflowError
        return value

    def activation(self, distance: float) -> float:
        """λ = c / v at u = w = 0, clipped to [0, 1]; 0 where the formula fails, or v = 0."""
        try:
            share = self.change(distance, 0.0, 0.0) / self._settings().nominal_velocity
        except (ArithmeticError, ValueError):
            return 0.0
        return min(max(share, 0.0), 1.0)

    def activations(self, distances: Array) -> Array:
        """λ (k,) at distances (k,) [m]; nan where the formula fails."""
        speed = self._settings().nominal_velocity
        return (
            np.clip(self._changes(distances, 0.0, 0.0) / speed, 0.0, 1.0)
            if speed
            else np.zeros(len(distances))
        )

    def line_rates(self, distances: Array, pull: float, approach: float, square: float) -> Array:
        """J_d q̇ = c − u [m/s] (k,) at distances (k,) [m]; nan where the formula fails."""
        del square
        return self._changes(distances, pull, approach) - pull

    def _changes(self, distances: Array, pull: float, approach: float) -> Array:
        with np.errstate(all="ignore"):
            found = self.formula.values(self._values(distances, pull, approach))
            found = np.broadcast_to(np.asarray(found, dtype=float), distances.shape)
            return np.where(np.abs(found) <= LARGEST, found, np.nan)

    def _values(self, distance: object, pull: float, approach: float) -> Sequence[object]:
        law = self._settings()
        return (
            distance,
            pull,
            approach,
            float(law.nominal_velocity),
            float(law.critical_distance),
            float(law.order),
        )

    def _fail(self, error: Exception, situation: Situation) -> None:
        match error:
            case ZeroDivisionError():
                what = LazyText("division by zero")
            case OverflowError():
                what = LazyText("a number that is too large, or not defined")
            case _:
                what = LazyText("a root, power or logarithm that is not a number")
        at = NumberText(
            f"d = {situation.distance:.4g} m, u = {situation.pull:.3g} m/s, w = {situation.approach:.3g} m/s"
        )
        self.problem = problem_of(FILE, LazyText("{what} at {where}.", what=what, where=at))

    # ---- `SessionLaw`: a formula never waits, and has no file

    @property
    def need(self) -> float:
        return 0.0

    @property
    def away(self) -> bool:
        return False

    @property
    def waiting(self) -> bool:
        return False

    def allow(self, seconds: float) -> None:
        del seconds

    def refresh(self) -> bool:
        return False

    def step_made(self) -> int:
        return 0

    def close(self) -> None:
        pass
