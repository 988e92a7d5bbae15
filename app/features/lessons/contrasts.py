"""How far a run that shows why an answer is wrong differs from the question's run, for the check of lessons."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from controllers.kinematics import Array
from scenes.history import COLUMN, SCALARS
from scenes.simulation import Simulation

LEAST_TURN: Final = 0.035
"""Smallest difference of a joint's angle that is seen in the 3-D view: 2° [rad], or 35 mm of a ball's place [m]."""

LEAST_DISTANCE: Final = 0.01
"""Smallest difference of the distance that is seen in its plot [m]."""

LEAST_SHARE: Final = 0.1
"""Smallest difference of the number that the question asks for, as a share of the larger one."""

LEAST_SWING: Final = 0.5
"""Smallest difference of two movements, as a share of the larger one, at which their curves are not nearly equal."""

ROWS: Final = 400
"""Moments at which two runs are compared."""


@dataclass(frozen=True)
class ContrastSize:
    """Largest differences between two runs.

    Attributes:
        turn: of a joint's angle [rad], or of a ball's place [m], at the same time.
        distance: of d at the same time [m]; 0 where nothing is near.
        share: of the number that is asked for, as a share of the larger one.
        swing: largest turn as a share of what that joint moves in either run.
    """

    turn: float
    distance: float
    share: float
    swing: float

    @property
    def seen(self) -> bool:
        return self.turn >= LEAST_TURN or self.distance >= LEAST_DISTANCE or self.share >= LEAST_SHARE

    @property
    def moves_otherwise(self) -> bool:
        """True if the runs' curves are told apart at a glance."""
        return self.turn >= LEAST_TURN and self.swing >= LEAST_SWING

    @property
    def text(self) -> str:
        turn, distance = f"{np.degrees(self.turn):.2g}°", f"{1000.0 * self.distance:.2g} mm"
        return f"joints differ by {turn}, d by {distance}, the number asked for by {100.0 * self.share:.2g} %"


def contrast_size(asked: Simulation, beside: Simulation, values: tuple[float | None, float | None]) -> ContrastSize:
    """Largest differences between two finished runs.

    Args:
        values: the number that the question asks for, in each run; None if a run does not tell it.
    """
    tables = [run.history.table() for run in (asked, beside)]
    begin = max(float(table[0, 0]) for table in tables)
    end = min(float(table[-1, 0]) for table in tables)
    times = np.linspace(begin, max(end, begin), ROWS)
    joints = len(asked.positions) if len(asked.positions) == len(beside.positions) else 0
    angles = range(len(SCALARS), len(SCALARS) + joints)
    turns = [(_difference(tables, times, column), _range(tables, column)) for column in angles]
    turn, moved = max(turns, default=(LEAST_TURN, LEAST_TURN))
    first, second = values
    if first is None or second is None:
        share = 0.0 if first is second else 1.0
    else:
        share = abs(first - second) / max(abs(first), abs(second), 1e-12)
    return ContrastSize(turn, _difference(tables, times, COLUMN["d"]), share, turn / max(moved, 1e-12))


def _difference(tables: list[Array], times: Array, column: int) -> float:
    """Largest finite difference of a column at the same times; 0 if it is nowhere known in both."""
    one, other = (np.interp(times, table[:, 0], table[:, column]) for table in tables)
    known = np.isfinite(one) & np.isfinite(other)
    return float(np.max(np.abs(one[known] - other[known]), initial=0.0))


def _range(tables: list[Array], column: int) -> float:
    return max(float(np.ptp(table[:, column])) for table in tables)
