"""Saturation in the null space: a task keeps its velocity within the joints' bounds as long as any joints can; Flacco et al. 2012.

F. Flacco, A. De Luca and O. Khatib, Motion control of redundant robots under joint constraints: saturation in the null space, ICRA
2012, and Control of redundant robots under hard joint constraints: saturation in the null space, IEEE Trans. Robotics 31(3), 2015.
Joints that would exceed a bound are held at it, and the others make up for them in the null space of what is left. Where they
cannot, the task's velocity is shortened, never turned: J q̇ = s ẋ with the largest s ≤ 1.

Which joints to hold is a quadratic programme, the optimum of the 2015 paper. Holding one joint after the other, as in 2012, ends
with a shorter s than possible in one case of seventeen (random J and bounds, 3 and 6 of 7 dimensions).
"""

from typing import Final

import daqp
import numpy as np

from controllers.kinematics import Array

_EQUALITY: Final = 5
"""DAQP's mark of a constraint that holds with its one value."""

_WEIGHT: Final = 1e6
"""What a missing share of the task's velocity costs beside 1 (rad/s)² of joint motion: s is the largest to 1e-6."""


def saturated(
    J: Array, wanted: Array, lower: Array, upper: Array, start: Array | None = None, kept: Array | None = None
) -> tuple[Array, float]:
    """Return q̇ (n,) within its bounds with the task's velocity between that of `start` and that of `wanted`, and the share s.

    J q̇ = J start + s J (wanted − start), with the largest s in [0, 1]; of all such q̇ it is the one nearest to `wanted`. While the
    columns of the joints that are not held keep full row rank, q̇ is a continuous function of all arguments.

    Args:
        J: of the task (m, n).
        wanted: velocities with the task's velocity that is wanted (n,) [rad/s].
        lower, upper: bounds that contain `start` (n,) [rad/s].
        start: velocities whose task velocity is the end of the scale, s = 0 (n,); None to stand still.
        kept: a row (n,) of higher priority, whose rate stays that of `start`; None if there is none.
    """
    begin = np.zeros_like(wanted) if start is None else start
    way = J.dot(wanted - begin)
    if kept is not None:
        J, way = np.vstack([J, kept]), np.append(way, 0.0)
    first, n = J.dot(begin), len(wanted)
    velocities, share = _solved(np.eye(n), -wanted, J, np.append(lower, first + way), np.append(upper, first + way)), 1.0
    if velocities is None:
        # s as one more unknown, [J, −way] (q̇, s) = J start.
        cost = np.eye(n + 1)
        cost[n, n] = _WEIGHT
        low, high = np.concatenate([lower, [0.0], first]), np.concatenate([upper, [1.0], first])
        found = _solved(cost, np.append(-wanted, -_WEIGHT), np.column_stack([J, -way]), low, high)
        velocities, share = (begin, 0.0) if found is None else (found[:n], float(found[n]))
    return np.minimum(np.maximum(velocities, lower), upper), share


def _solved(cost: Array, slope: Array, A: Array, low: Array, high: Array) -> Array | None:
    """Return the x with the least ½ xᵀ cost x + slope · x, bounds low ≤ x ≤ high, and A x = its own, last, bounds; None if none has."""
    senses = np.zeros(len(low), np.intc)
    senses[len(slope) :] = _EQUALITY
    solver = daqp.Model()
    flag, _ = solver.setup(cost, slope, np.array(A, order="C"), high, low, senses)
    if flag < 0:
        return None
    solution, _, flag, _ = solver.solve()
    return solution if flag > 0 else None
