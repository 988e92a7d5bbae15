"""Joint position and velocity bounds that keep the avoidance.

Clipping q̇ after the law would lose the clipped joint's share of the retreat. Instead:

    min |q̇ − q̇_n|²   subject to   J_d q̇ = r,   lower ≤ q̇ ≤ upper,

with the law's distance rate r. The solution is q̇ = clip(q̇_n + c J_dᵀ) with one scalar c: water filling
along the row. Without an active bound this is the law's own q̇. An arm that cannot reach r is out of
authority.

dr/dc is |J_d|² of the joints not yet at a bound. Near 0, c would go to infinity, and joints with almost no
lever would jump between their bounds. So c is computed with dr/dc = |J_d|² + μ², see `row_damping`: exact
while |J_d| ≥ 0.12 m/rad remains. Below it c stays finite, and q̇ is a Lipschitz function of q̇_n, J_d, r and
the bounds, also where r becomes impossible.
"""

from enum import IntEnum
from typing import Final, NamedTuple

import numpy as np

from controllers.choices import BoundsTreatment
from controllers.compiled import Vector, loop
from controllers.kinematics import Array
from controllers.laws.situation import row_damping
from controllers.null_space_saturation import saturated

TOLERANCE: Final = 1e-6
"""Smaller errors of the distance rate count as reached [m/s]."""

FELT: Final = 1e-6
"""Smaller entries of J_d are rounding noise [m/rad]."""


class Authority(IntEnum):
    FULL = 0
    STOP = 1
    SPEED = 2
    LEVERAGE = 3
    """J_d is nearly singular: no joint changes the distance."""
    WORLD = 4
    """A later stage takes part of the distance rate."""


class Bounded(NamedTuple):
    """A feasible velocity.

    Attributes:
        velocities: q̇ (n,) [rad/s].
        authority: FULL, or the reason why the distance rate cannot be reached.
        joint: index of the joint that costs most of it, −1 for none.
    """

    velocities: Array
    authority: Authority = Authority.FULL
    joint: int = -1


@loop(
    "void(float64[:], float64[:], float64[:], float64[:], float64, float64[:], float64[:])",
    fills=("lower", "upper"),
)
def fill_bounds(
    positions: Vector,
    lowest: Vector,
    highest: Vector,
    top_speed: Vector,
    gain: float,
    lower: Vector,
    upper: Vector,
) -> None:
    for i in range(len(positions)):
        lower[i] = max(gain * (lowest[i] - positions[i]), -top_speed[i])
        upper[i] = min(gain * (highest[i] - positions[i]), top_speed[i])


@loop("boolean(float64[:], float64[:], float64[:])")
def is_inside(velocities: Vector, lower: Vector, upper: Vector) -> bool:
    for i in range(len(velocities)):  # noqa: SIM110 (no generators in a loop)
        if not lower[i] <= velocities[i] <= upper[i]:
            return False
    return True


class VelocityBox:
    """Permitted velocities of an arm at q: lower ≤ q̇ ≤ upper.

    Near a stop at most g times the remaining angle: a joint cannot pass it as long as g dt ≤ 1.

    Args:
        lower_position, upper_position: joint stops (n,) [rad].
        top_speed: (n,) [rad/s].
        gain: g [1/s].
    """

    def __init__(self, lower_position: Array, upper_position: Array, top_speed: Array, gain: float) -> None:
        self._lower_position, self._upper_position = lower_position, upper_position
        self._top_speed = top_speed
        self.lower = -top_speed
        self.upper = top_speed.copy()
        self.gain = gain

    def update(self, positions: Array) -> None:
        """Compute `lower` and `upper` (n,) [rad/s] at q (n,)."""
        fill_bounds(
            positions,
            self._lower_position,
            self._upper_position,
            self._top_speed,
            self.gain,
            self.lower,
            self.upper,
        )

    def part(self, joints: slice) -> "VelocityBox":
        """Box of some joints with shared bounds: `update` of the whole updates it."""
        part = VelocityBox(
            self._lower_position[joints], self._upper_position[joints], self._top_speed[joints], self.gain
        )
        part.lower, part.upper = self.lower[joints], self.upper[joints]
        return part

    def clip(self, velocities: Array) -> Array:
        """Nearest velocity (n,) in the box [rad/s]; for a *task's* velocity, never for a law's."""
        return np.minimum(np.maximum(velocities, self.lower), self.upper)

    def largest_share(self, velocities: Array) -> tuple[float, int]:
        """Largest s in [0, 1] with s q̇ (n,) in the box, and the joint that bounds it, or −1."""
        share, joint = 1.0, -1
        for i, (speed, low, high) in enumerate(
            zip(velocities.tolist(), self.lower.tolist(), self.upper.tolist(), strict=True)
        ):
            if speed > high or speed < low:
                possible = max((high if speed > high else low) / speed, 0.0) if speed else 0.0
                if possible < share:
                    share, joint = possible, i
        return share, joint

    def contains(self, velocities: Array) -> bool:
        return is_inside(velocities, self.lower, self.upper)

    def lost_speed(self, direction: Array) -> Array:
        """Top speed that each joint loses to a stop (n,) [rad/s]; only the signs of `direction` (n,) count."""
        return np.where(direction > 0.0, self._top_speed - self.upper, self._top_speed + self.lower)


def bounded_row(nominal: Array, row: Array, rate: float, box: VelocityBox) -> Bounded:
    """Velocity in the box nearest to `nominal` with the distance rate `rate`, or as near to it as possible.

    Args:
        nominal: q̇_n (n,) inside the box [rad/s].
        row: J_d (n,) [m/rad].
        rate: r = J_d q̇ of the law [m/s].
    """
    qn, j, lower, upper = nominal.tolist(), row.tolist(), box.lower.tolist(), box.upper.tolist()
    wanted = rate - sum(a * b for a, b in zip(j, qn, strict=True))
    sign = 1.0 if wanted >= 0.0 else -1.0
    # Way along the row, in units of c, until each joint meets its bound.
    ends: list[tuple[float, int]] = []
    square = 0.0
    for i, (ji, qi) in enumerate(zip(j, qn, strict=True)):
        if ji != 0.0:
            room = (upper[i] - qi) if sign * ji > 0.0 else (qi - lower[i])
            ends.append((max(room, 0.0) / abs(ji), i))
            square += ji * ji
    ends.sort()
    left, c = abs(wanted), 0.0
    for end, i in ends:
        slope = square + row_damping(square)
        counted = slope * (end - c)
        if counted >= left:
            c += left / slope
            break
        left -= counted
        c = end
        square = max(square - j[i] * j[i], 0.0)
    velocities = box.clip(nominal + row * (sign * c))
    if abs(rate - float(row.dot(velocities))) <= TOLERANCE:
        return Bounded(velocities)
    lost = np.abs(row) * box.lost_speed(sign * row)
    joint = int(np.argmax(lost))
    if lost[joint] > TOLERANCE:
        return Bounded(velocities, Authority.STOP, joint)
    return Bounded(velocities, Authority.SPEED, int(np.argmax(np.abs(row))))


def shortened_row(wanted: Array, row: Array, box: VelocityBox) -> Bounded:
    """Largest share of a law's velocity q̇ (n,) [rad/s] in the box."""
    share, joint = box.largest_share(wanted)
    velocities = box.clip(share * wanted)
    if (1.0 - share) * abs(float(row.dot(wanted))) <= TOLERANCE:
        return Bounded(velocities)
    at_stop = float(box.lost_speed(wanted)[joint]) > TOLERANCE
    return Bounded(velocities, Authority.STOP if at_stop else Authority.SPEED, joint)


def bounded_task(wanted: Array, J: Array | None, box: VelocityBox, treatment: BoundsTreatment) -> Array:
    """A *task's* velocity (n,) in the box [rad/s]: clipped joint by joint, shortened, or with the hand's
    velocity kept.

    Args:
        wanted: q̇_n (n,) [rad/s].
        J: (m, n); None if the task uses every joint.
    """
    if treatment == "distance" or box.contains(wanted):
        return box.clip(wanted)
    if treatment == "scale" or J is None:
        return box.clip(box.largest_share(wanted)[0] * wanted)
    return saturated(J, wanted, box.lower, box.upper)[0]
