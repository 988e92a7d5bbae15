"""Several first tasks as one: the smooth minimum of their ratios h_k/h_m,k.

    h = −(h_m/β') ln Σ exp(−β' h_k/h_m,k),      J_a = Σ p_k (h_m/h_m,k) J_k,      w = Σ p_k (h_m/h_m,k) w_k,

in the unit of the first one and with its h_m and v. A task with another threshold is kept at the rate
h_m,k/h_m · v. J_a vanishes between two opposed tasks with equal ratios: no law can win there.

Source: ours. Mansard, Khatib & Kheddar (IEEE Trans. Robotics 25(3), 2009) use products of projectors.
"""

from collections.abc import Sequence

import numpy as np

from controllers.first_tasks.first_task import FirstTask, Margin
from controllers.proximity import smooth_minimum


class SeveralAtOnce(FirstTask):
    """h: smooth minimum of several first tasks of one arm, in the unit of the first.

    Args:
        tasks: at least one.
        sharpness: β', dimensionless.
    """

    def __init__(self, tasks: Sequence[FirstTask], name: str, sharpness: float = 3.0) -> None:
        first = tasks[0]
        super().__init__(first.critical_value, first.nominal_rate)
        self.name, self.unit, self.authority = name, first.unit, first.authority
        self.tasks = tuple(tasks)
        self._shares = [first.critical_value / task.critical_value for task in tasks]
        self._beta = sharpness / first.critical_value
        self._values = np.empty(len(tasks))

    def margin(self) -> Margin:
        margins = [task.margin() for task in self.tasks]
        if len(margins) == 1:
            return margins[0]
        row = np.empty(len(margins[0].row))
        values, rows = self._values, np.empty((len(margins), len(row)))
        w = 0.0
        for i, (share, margin) in enumerate(zip(self._shares, margins, strict=True)):
            values[i] = share * margin.value
            np.multiply(margin.row, share, out=rows[i])
            w += abs(margin.approach)
        h = smooth_minimum(values, rows, self._beta, row)
        if w != 0.0:
            weights = np.exp(self._beta * (h - values)) * self._shares
            w = sum(
                weight * margin.approach for weight, margin in zip(weights.tolist(), margins, strict=True)
            )
        return Margin(h, row, w)
