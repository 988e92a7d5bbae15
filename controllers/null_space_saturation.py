"""Saturation in the null space: a task keeps its velocity as long as joints can.

Flacco, De Luca & Khatib, ICRA 2012, and IEEE Trans. Robotics 31(3), 2015. Joints that would exceed a bound
are held at it, and the others compensate in the remaining null space. If they cannot, the task's velocity is
shortened, never turned: J q̇ = s ẋ with s < 1.

A quadratic programme finds the joints to hold, after the optimum of the 2015 paper. Holding one joint after
the other (2012) gives a shorter s than possible in one case of seventeen (random J and bounds, 3 and 6 of 7
dimensions).
"""

from typing import Final

import daqp
import numpy as np

from controllers.kinematics import Array

_EQUALITY: Final = 5

_WEIGHT: Final = 1e3
"""Cost of 1 − s against joint motion [(rad/s)²]: s is exact to some hundredths. 1e6 would be exact to 1e-6,
but joints with little effect on s would jump between bounds.
"""

_DEPENDENT: Final = 1e-6
"""Smallest joint effect on a direction of the task that counts [m/rad]."""


def saturated(
    J: Array, wanted: Array, lower: Array, upper: Array, start: Array | None = None, kept: Array | None = None
) -> tuple[Array, float]:
    """q̇ (n,) [rad/s] within its bounds with the task's velocity between those of `start` and `wanted`, and
    the share s.

    J q̇ = J start + s J (wanted − start), with s = 1 or nearly the largest possible; of these q̇ the nearest
    to start + s (wanted − start). It is continuous while s = 1, and while s < 1. Where s = 1 becomes
    impossible it jumps: s falls by some hundredths, which relieves the last free joints.

    Args:
        J: of the task (m, n).
        wanted: velocities with the desired task velocity (n,).
        lower, upper: bounds that contain `start` (n,).
        start: velocities of s = 0 (n,); None for zero.
        kept: a row (n,) of higher priority, which keeps the rate of `start`, or None.
    """
    begin = np.zeros_like(wanted) if start is None else start
    change, n = wanted - begin, len(wanted)
    A, way = _independent(J, J.dot(change), kept)
    first = A.dot(begin)
    velocities, share = (
        _solved(np.eye(n), -wanted, A, np.append(lower, first + way), np.append(upper, first + way)),
        1.0,
    )
    if velocities is None:
        # s is one more unknown: [A, −way] (q̇, s) = A start, and the squared distance is |q̇ − s change − start|².
        cost = np.eye(n + 1)
        cost[:n, n] = cost[n, :n] = -change
        cost[n, n] = _WEIGHT + change.dot(change)
        slope = np.append(-begin, change.dot(begin) - _WEIGHT)
        low, high = np.concatenate([lower, [0.0], first]), np.concatenate([upper, [1.0], first])
        found = _solved(cost, slope, np.column_stack([A, -way]), low, high)
        velocities, share = (begin, 0.0) if found is None else (found[:n], float(found[n]))
    return np.minimum(np.maximum(velocities, lower), upper), share


def _independent(J: Array, way: Array, kept: Array | None) -> tuple[Array, Array]:
    """Orthonormal rows A (k, n) and rates (k,) for J y = way and kept · y = 0."""
    unit = None if kept is None or not kept.any() else kept[None, :] / np.linalg.norm(kept)
    left, values, right = np.linalg.svd(
        J if unit is None else J - J.dot(unit.T).dot(unit), full_matrices=False
    )
    felt = values > _DEPENDENT
    A, rates = right[felt], left.T[felt].dot(way) / values[felt]
    return (A, rates) if unit is None else (np.vstack([A, unit]), np.append(rates, 0.0))


def _solved(cost: Array, slope: Array, A: Array, low: Array, high: Array) -> Array | None:
    """Minimiser of ½ xᵀ cost x + slope · x; bounds of x, then equal ones of A x. None if infeasible."""
    senses = np.zeros(len(low), np.intc)
    senses[len(slope) :] = _EQUALITY
    solver = daqp.Model()
    flag, _ = solver.setup(cost, slope, np.array(A, order="C"), high, low, senses)
    if flag < 0:
        return None
    solution, _, flag, _ = solver.solve()
    return solution if flag > 0 else None
