"""One inequality per pair, all pairs at once."""

from dataclasses import dataclass
from functools import cache
from typing import ClassVar, Final

import daqp
import numpy as np

from controllers.kinematics import Array
from controllers.laws.situation import Law, Situation, along_row, row_dampings

HARDNESS: Final = 1e-8
"""ρ of a regular row [m²/rad²]; avoidable violations stay below about 1e-6 m/s."""

FREE_SPEED: Final = 1.0
"""Approach speed that nothing in the room exceeds [m/s]."""

_SOFT: Final = 8

_UNBOUNDED: Final = 1e30


@dataclass(frozen=True)
class BarrierQP(Law):
    """min |q̇ − q̇_n|²  subject to  J_d,i q̇ ≥ −γ (d_i − d_m) + w_i  for every pair i,  and  lower ≤ q̇ ≤
    upper.

    Faverjon & Tournassoud, ICRA 1987 (velocity damper); γ is their ξ / (d_i − d_s), here at every distance.
    It is also the control barrier function condition ḣ ≥ −γ h for h = d − d_m (Ames et al., ECC 2019). The
    task may approach more slowly the nearer it is; slower motion is unchanged.

    Without `feed_forward` w is ignored, and d falls below d_m by w / γ before a resting arm follows.

    DAQP (Arnström, Bemporad & Axehill, IEEE Trans. Automatic Control 67(8), 2022) starts cold, so that equal
    situations give equal bits. The bounds are hard. The rows are soft, so that a solution always exists: the
    cost s² / (2 μ²) of a shortfall s damps a row like its pseudo-inverse elsewhere, and two conflicting pairs
    are each violated a little.

    Attributes:
        critical_distance: d_m [m], where no approach is permitted.
        barrier_gain: γ [1/s]; γ dt < 1 keeps the bound in discrete time.
        feed_forward: include w.
    """

    wants_all_pairs: ClassVar[bool] = True

    critical_distance: float
    barrier_gain: float
    feed_forward: bool = False

    def activation(self, distance: float) -> float:
        """1 − permitted approach speed / (1 m/s), in [0, 1]."""
        permitted = self.barrier_gain * (distance - self.critical_distance)
        return min(max(1.0 - permitted / FREE_SPEED, 0.0), 1.0)

    def line_rate(self, distance: float, pull: float, approach: float, square: float) -> float:
        """J_d q̇ = max(−u, −γ (d − d_m) + w) [m/s]."""
        del square
        least = -self.barrier_gain * (distance - self.critical_distance)
        if self.feed_forward:
            least += approach
        return max(-pull, least)

    def __call__(self, situation: Situation) -> Array:
        nominal, lower, upper = situation.nominal, situation.lower, situation.upper
        rows, least = pair_rates(self, situation)
        start = nominal
        if lower is not None and upper is not None:
            # A joint beyond its stop may have lower > upper; its return has priority.
            upper = np.maximum(lower, upper)
            start = np.minimum(np.maximum(nominal, lower), upper)
        if not np.count_nonzero(rows.dot(start) < least):
            return start
        velocities = nearest(nominal, rows, least, lower, upper)
        if velocities is None:
            # The problem always has a solution, but the solver may cycle: then use the pair that needs it most.
            shortfalls = least - rows.dot(nominal)
            worst = int(shortfalls.argmax())
            velocities = along_row(nominal, rows[worst], float(shortfalls[worst]))
        if lower is None or upper is None:
            return velocities
        # DAQP keeps bounds to 1e-6 only.
        return np.minimum(np.maximum(velocities, lower, out=velocities), upper, out=velocities)


def pair_rates(law: BarrierQP, situation: Situation) -> tuple[Array, Array]:
    """Rows J_d (pairs, n) [m/rad] and least rates (pairs,) [m/s]."""
    rows, distances, approaches = situation.rows, situation.distances, situation.approaches
    if rows is None or distances is None:
        rows, distances, approaches = (
            situation.row[None, :],
            np.array([situation.distance]),
            np.array([situation.approach]),
        )
    least = distances - law.critical_distance
    least *= -law.barrier_gain
    if law.feed_forward and approaches is not None:
        least += approaches
    return rows, least


def nearest(
    nominal: Array,
    rows: Array,
    least: Array,
    lower: Array | None,
    upper: Array | None,
    weight: Array | None = None,
) -> Array | None:
    """Velocity (n,) nearest to q̇_n with rows · q̇ ≥ least (soft) and within the bounds; None if the solver
    fails.

    Args:
        nominal: q̇_n (n,) [rad/s].
        rows, least: (pairs, n) [m/rad], (pairs,) [m/s].
        lower, upper: (n,) [rad/s]; None for no bounds.
        weight: (n, n) metric; None for I.
    """
    n, pairs = len(nominal), len(rows)
    first = 0 if lower is None or upper is None else n
    above, below = np.full(first + pairs, _UNBOUNDED), np.empty(first + pairs)
    if lower is not None and upper is not None:
        above[:n], below[:n] = upper, lower
    np.maximum(least, -_UNBOUNDED, out=below[first:])
    softness = np.empty(first + pairs)
    softness[:first] = HARDNESS
    softness[first:] = row_dampings((rows * rows).sum(axis=1))
    softness[first:] += HARDNESS
    solver = daqp.Model()
    # Copies, because the solver wants contiguous memory that it may write to.
    metric, linear = (_identity(n), -nominal) if weight is None else (weight, -weight.dot(nominal))
    flag, _ = solver.setup(metric, linear, np.array(rows, order="C"), above, below, _senses(first, pairs))
    if flag >= 0:
        solver.soft_weights(rho_l=softness)
        velocities, _, flag, _ = solver.solve()
        if flag > 0:
            return velocities
    return None


@cache
def _identity(n: int) -> Array:
    return np.eye(n)


@cache
def _senses(first: int, pairs: int) -> np.ndarray:
    senses = np.zeros(first + pairs, np.intc)
    senses[first:] = _SOFT
    return senses
