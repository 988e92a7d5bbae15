"""Differences between a question's run and one that explains a wrong answer."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from controllers.kinematics import Array
from scenes.history import COLUMN, SCALARS
from scenes.simulation import Simulation

LEAST_TURN: Final = 0.035
"""Smallest visible difference in the 3-D view: 2° of a joint [rad], 35 mm of a ball [m]."""

LEAST_DISTANCE: Final = 0.01
"""Smallest visible difference in the plot of d [m]."""

LEAST_SHARE: Final = 0.1
"""Smallest relative difference of the asked number."""

LEAST_SWING: Final = 0.5
"""Smallest visible relative difference of two movements."""

ROWS: Final = 400


@dataclass(frozen=True)
class ContrastSize:
    """Largest differences between two runs at the same time.

    Attributes:
        turn: of a joint [rad] or a ball's place [m].
        distance: of d [m]; 0 without an obstacle.
        share: of the asked number, relative to the larger value.
        swing: `turn`, relative to the joint's larger range.
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
        return self.turn >= LEAST_TURN and self.swing >= LEAST_SWING

    @property
    def text(self) -> str:
        turn, distance = f"{np.degrees(self.turn):.2g}°", f"{1000.0 * self.distance:.2g} mm"
        return f"joints differ by {turn}, d by {distance}, the number asked for by {100.0 * self.share:.2g} %"


def contrast_size(
    asked: Simulation, beside: Simulation, values: tuple[float | None, float | None]
) -> ContrastSize:
    """Compare two finished runs. `values`: the asked number in each run."""
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
    """0 if the runs share no finite value."""
    one, other = (np.interp(times, table[:, 0], table[:, column]) for table in tables)
    known = np.isfinite(one) & np.isfinite(other)
    return float(np.max(np.abs(one[known] - other[known]), initial=0.0))


def _range(tables: list[Array], column: int) -> float:
    return max(float(np.ptp(table[:, column])) for table in tables)
