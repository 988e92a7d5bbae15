"""The smooth minimum of the ways to both stops of every joint.

    h = −ln Σ exp(−β m_k) / β over m = (q_i − q_i,low, q_i,high − q_i),      J_a = Σ p_k ∂m_k/∂q,

with p_k = exp(−β m_k) / Σ exp(−β m_l) and ∂m_k/∂q = ± e_i. h is at most ln(2n)/β below the least way. J_a
vanishes where every joint is in the middle of its range; λ is small there.

Source: ours, for "constraining the joint space" in the outlook of Petrič & Žlajpah 2011. Chan & Dubey (IEEE
Trans. Robotics and Automation 11(2), 1995) weight the joints instead.
"""

import math
from typing import Final

import numpy as np

from controllers.compiled import Vector, loop
from controllers.first_tasks.first_task import FirstTask, Margin
from controllers.kinematics import Array

SHARPNESS: Final = 60.0
"""β [1/rad]: for seven joints h is at most 2.5° below the least way."""


@loop("float64(float64[:], float64[:], float64[:], float64, float64[:])", fills=("row",))
def way_to_stops(positions: Vector, lowest: Vector, highest: Vector, beta: float, row: Vector) -> float:
    """h [rad]; fills J_a, all (n,) [rad]; β [1/rad]."""
    n = len(positions)
    # The least of them goes first: no exponential is too large, also beyond a stop.
    least = positions[0] - lowest[0]
    for i in range(n):
        least = min(least, positions[i] - lowest[i], highest[i] - positions[i])
    total = 0.0
    for i in range(n):
        low = math.exp(beta * (least - (positions[i] - lowest[i])))
        high = math.exp(beta * (least - (highest[i] - positions[i])))
        row[i] = low - high
        total += low + high
    for i in range(n):
        row[i] /= total
    return float(least - math.log(total) / beta)


class JointStops(FirstTask):
    """h: smooth minimum of the ways of all joints to their stops [rad].

    Args:
        positions: q (n,), a live view [rad].
        lowest, highest: (n,) [rad].
    """

    name = "way to the joint stops"
    unit = "rad"

    def __init__(
        self,
        positions: Array,
        lowest: Array,
        highest: Array,
        critical_value: float = 0.17,
        nominal_rate: float = 1.0,
    ) -> None:
        super().__init__(critical_value, nominal_rate)
        self._positions, self._lowest, self._highest = positions, lowest, highest

    def margin(self) -> Margin:
        row = np.empty(len(self._positions))
        return Margin(way_to_stops(self._positions, self._lowest, self._highest, SHARPNESS, row), row)
