"""A simulation that records every stage, to check the promise of each."""

from dataclasses import dataclass, field

import numpy as np

from controllers.first_tasks.first_task import Margin
from controllers.kinematics import Array
from controllers.laws.situation import AUTHORITY, FIRM_LEVER, lever
from controllers.limits import TOLERANCE, Authority, Bounded
from controllers.row_stage import RowStage
from scenes.history import COLUMN
from scenes.settings import RunSettings
from scenes.simulation import HISTORY, Simulation

NOTED = ("law_d", "lambda", "u", "w_law", "lever", "authority", "joint")
"""History columns of one stage."""


@dataclass(frozen=True)
class WatchedStage(RowStage):
    """A stage that records each of its steps.

    Attributes:
        numbers: of every step, as in `NOTED`.
        rows: J_a (n,) of every step.
        left: q̇ (n,) for the next stage [rad/s].
    """

    numbers: list[tuple[float, ...]] = field(default_factory=list[tuple[float, ...]])
    rows: list[Array] = field(default_factory=list[Array])
    left: list[Array] = field(default_factory=list[Array])

    def bounded(self, nominal: Array, margin: Margin) -> Bounded:
        made, row = super().bounded(nominal, margin), margin.row
        scale = AUTHORITY / self.task.authority
        s = lever(scale * scale * float(row.dot(row)))
        lam = self.law.activation(margin.value)
        authority = made.authority
        if lam > 0.5 and s < FIRM_LEVER and authority is Authority.FULL:
            authority = Authority.LEVERAGE
        pull = -float(row.dot(nominal))
        self.numbers.append((margin.value, lam, pull, margin.approach, s, int(authority), made.joint))
        self.rows.append(row.copy())
        self.left.append(made.velocities.copy())
        return made

    def table(self, history: Array, velocities: Array) -> Array:
        """A history table (rows, columns) with the columns of this stage.

        Args:
            velocities: q̇ (rows, n) after all stages [rad/s].
        """
        table, noted = history.copy(), np.array(self.numbers)
        lost = np.einsum("ij,ij->i", np.array(self.rows), np.array(self.left) - velocities)
        # As in `Simulation`: a later stage may override this one.
        authority = noted[:, NOTED.index("authority")]
        taken = (noted[:, NOTED.index("lambda")] > 0.5) & (authority == Authority.FULL) & (lost > TOLERANCE)
        authority[taken] = Authority.WORLD
        table[:, [COLUMN[name] for name in NOTED]] = noted
        return table


class WatchedStages(Simulation):
    """Records its stages from the last `reset` on."""

    def __init__(self, settings: RunSettings, capacity: int = HISTORY) -> None:
        self.watched: tuple[WatchedStage, ...] = ()
        super().__init__(settings, capacity)

    def _form(self) -> None:
        super()._form()
        self.watched = tuple(WatchedStage(one.task, one.law, one.box) for one in self._further)
        self._further = self.watched

    def tables(self) -> tuple[Array, ...]:
        """Histories of all first tasks: the law's own, then one of every stage."""
        table, history = self.history.table(), self.history
        velocities = history.velocities(table)[:, self.avoiding.joints]
        return (table, *(stage.table(table, velocities) for stage in self.watched))
