"""Joints 1 … 4 of an LWR that point its upper arm and forearm like a person's.

Axes 1 to 3 of the LWR, z, −y, z, meet in the shoulder; the fourth, +y, is the elbow (`scenes.lwr.facts`).
With the directions ū and f̄ of the person's upper arm and forearm in the base's frame,

    ū = Rz(q1) Ry(−q2) ẑ,      w = [Rz(q1) Ry(−q2)]ᵀ f̄ = Rz(q3) Ry(q4) ẑ,

so that, with σ and ε = ±1 for the four branches,

    q1 = atan2(−σ ū_y, −σ ū_x),  q2 = σ acos ū_z,  q3 = atan2(ε w_y, ε w_x),  q4 = ε acos w_z.

q1 of an upper arm on the base's axis, and q3 of a forearm on the upper arm's, keep their previous values.
Each joint in turn is clipped to its limits; the next one minimises the error.
"""

import math
from typing import Final

import numpy as np

from controllers.compiled import Matrix, Vector, loop
from controllers.kinematics import Array
from scenes.lwr.facts import JOINTS
from scenes.person.angles import SIGN, fill_directions, remembered, wrapped
from scenes.rigs import Rig

DRIVEN: Final = 4

LIMIT_MARGIN: Final = float(np.radians(3.0))
"""Clearance of desired joints from their stops [rad]."""

TRUSTED_SINE: Final = 0.05
"""Least sine of the bone's angle off the axis for an unchanged q1 and q3."""

EXACT: Final = 1e-9
"""A smaller error of a direction counts as 0 [rad]."""

_LIMITS: Final = np.array([joint.position_limit - LIMIT_MARGIN for joint in JOINTS[:DRIVEN]])


@loop(
    "void(float64[:], float64[:], float64[:, :], float64[:], boolean, float64[:], float64[:])",
    fills=("joints",),
)
def fill_joints(
    upper: Vector, forearm: Vector, base: Matrix, limits: Vector, known: bool, before: Vector, joints: Vector
) -> None:
    """Fill q1 … q4 (4,) [rad] of one LWR: of the branches without error the nearest to the last sample.

    Args:
        upper, forearm: unit vectors (3,) towards the hand, world.
        base: R (3, 3) of the base, world.
        limits: (4,) [rad].
        known: False without a last sample: the natural branch is preferred.
        before: joints of that sample (4,) [rad].
    """
    ux = upper[0] * base[0, 0] + upper[1] * base[1, 0] + upper[2] * base[2, 0]
    uy = upper[0] * base[0, 1] + upper[1] * base[1, 1] + upper[2] * base[2, 1]
    uz = upper[0] * base[0, 2] + upper[1] * base[1, 2] + upper[2] * base[2, 2]
    fx = forearm[0] * base[0, 0] + forearm[1] * base[1, 0] + forearm[2] * base[2, 0]
    fy = forearm[0] * base[0, 1] + forearm[1] * base[1, 1] + forearm[2] * base[2, 1]
    fz = forearm[0] * base[0, 2] + forearm[1] * base[1, 2] + forearm[2] * base[2, 2]
    b1, b2, b3, b4 = (before[0], before[1], before[2], before[3]) if known else (0.0, 0.0, 0.0, 0.0)
    misses, least = True, math.inf
    # σ and ε; in the first branch ordinary gestures stay far from all stops on the torso.
    for sigma, epsilon in ((1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)):
        q1, q2, miss_upper = pan_tilt(ux, uy, uz, sigma, -1.0, limits[0], limits[1], known, b1)
        c1, s1, c2, s2 = math.cos(q1), math.sin(q1), math.cos(q2), math.sin(q2)
        x, wy = c1 * fx + s1 * fy, c1 * fy - s1 * fx
        wx, wz = c2 * x + s2 * fz, c2 * fz - s2 * x
        q3, q4, miss_forearm = pan_tilt(wx, wy, wz, epsilon, 1.0, limits[2], limits[3], known, b3)
        miss, way = miss_upper + miss_forearm, 0.0
        if known:
            way = (q1 - b1) ** 2 + (q2 - b2) ** 2 + (q3 - b3) ** 2 + (q4 - b4) ** 2
        # If every branch misses, a slightly smaller error is not worth a large jump.
        exact = miss < EXACT
        rank = way if exact else miss + 0.05 * way
        if (exact and misses) or (exact != misses and rank < least):
            misses, least = not exact, rank
            joints[0], joints[1], joints[2], joints[3] = q1, q2, q3, q4


@loop("UniTuple(float64, 3)(float64, float64, float64, float64, float64, float64, float64, boolean, float64)")
def pan_tilt(
    x: float,
    y: float,
    z: float,
    branch: float,
    sense: float,
    pan_limit: float,
    tilt_limit: float,
    known: bool,
    before: float,
) -> tuple[float, float, float]:
    """Pan about z and a tilt after it that point at the unit vector (x, y, z), and their error [rad].

    Args:
        branch: desired sign of the tilt.
        sense: +1 if a positive tilt leans towards +x at pan = 0, −1 if towards −x.
        pan_limit, tilt_limit: [rad].
        known: False without a last sample.
        before: pan of that sample [rad].
    """
    lean = math.sqrt(x * x + y * y)
    toward = branch * sense
    pan = math.atan2(toward * y, toward * x) if lean > 1e-12 else before
    if known:
        pan = remembered(pan, before, lean, TRUSTED_SINE)
        if abs(wrapped(pan)) <= pan_limit:
            pan = wrapped(pan)
    pan = min(max(pan, -pan_limit), pan_limit)
    cp, sp = math.cos(pan), math.sin(pan)
    ahead, aside = sense * (cp * x + sp * y), cp * y - sp * x
    best = math.atan2(ahead, z)
    tilt = min(max(best, -tilt_limit), tilt_limit)
    reach, short = math.sqrt(ahead * ahead + z * z), best - tilt
    off = reach * math.sin(short)
    return pan, tilt, math.atan2(math.sqrt(aside * aside + off * off), reach * math.cos(short))


@loop(
    "void(float64[:], float64, float64[:, :], float64[:], boolean, float64[:], float64[:])",
    fills=("joints",),
)
def fill_robot_arm(
    angles: Vector, sign: float, base: Matrix, limits: Vector, known: bool, before: Vector, joints: Vector
) -> None:
    """As `fill_joints`, from one arm's angles (4,) [rad]. `sign`: s of the arm."""
    upper, forearm = np.empty(3), np.empty(3)
    fill_directions(angles, sign, upper, forearm)
    fill_joints(upper, forearm, base, limits, known, before, joints)


class Retargeter:
    """A person's angles, in the world's frame (x forward, y left, z up) → joints of both robots."""

    def __init__(self, rig: Rig) -> None:
        self._bases = tuple(base.rotation.copy() for base in rig.bases)
        self._previous: Array | None = None

    def reset(self, joints: Array | None = None) -> None:
        """Continue from these joints (2, 4) [rad], or choose a branch again."""
        self._previous = None if joints is None else joints.copy()

    def joints(self, angles: Array) -> Array:
        """q1 … q4 (2, 4) [rad], left robot first, inside their limits.

        Args:
            angles: (2, 4) [rad], the person's left arm first.
        """
        wanted = np.empty((2, DRIVEN))
        for i, side in enumerate(SIGN):
            sign, before = SIGN[side], wanted[i] if self._previous is None else self._previous[i]
            fill_robot_arm(
                angles[i], sign, self._bases[i], _LIMITS, self._previous is not None, before, wanted[i]
            )
        self._previous = wanted
        return wanted.copy()

    def memory(self) -> tuple[Array, ...]:
        """Joints of the last sample (2, 4) [rad], or ()."""
        return () if self._previous is None else (self._previous.copy(),)

    def remember(self, memory: tuple[Array, ...]) -> None:
        self.reset(memory[0] if memory else None)


CUTOFF: Final = 3.0
"""Cutoff above a person's gestures and below a camera's noise [Hz]."""

TOP_RATE: Final = 1.6
"""Just below the slowest LWR joint, 100 °/s [rad/s]."""


@loop(
    "void(float64[:, :], float64, float64, float64, float64[:, :], float64[:, :])",
    fills=("values", "rates"),
)
def fill_filtered(
    goal: Matrix, omega: float, top_rate: float, dt: float, values: Matrix, rates: Matrix
) -> None:
    """See `AngleFilter`; all arrays are (rows, k)."""
    for i in range(goal.shape[0]):
        for j in range(goal.shape[1]):
            gap = goal[i, j] - values[i, j]
            size = abs(gap)
            straight = min(max(size - top_rate / omega, 0.0) / top_rate, dt)
            left = math.copysign((size - top_rate * straight) * math.exp(omega * (straight - dt)), gap)
            value = goal[i, j] - left
            rates[i, j] = (value - values[i, j]) / dt
            values[i, j] = value


class AngleFilter:
    """A first-order low-pass with a top speed: the output y follows the input x by

        ẏ = clip(ω (x − y), ± top_rate),   ω = 2π cutoff,

    solved exactly for a constant input: two steps of dt/2 equal one of dt.

    Args:
        start: first output (rows, k) [rad].
        top_rate: [rad/s].

    Attributes:
        values: output [rad].
        rates: its mean speed in the last step [rad/s].
        lost_for: time without input [s].
    """

    def __init__(self, start: Array, cutoff_hz: float = CUTOFF, top_rate: float = TOP_RATE) -> None:
        self._omega, self._top_rate = math.tau * cutoff_hz, top_rate
        self.reset(start)

    def reset(self, start: Array) -> None:
        """Rest at these values (rows, k) [rad]."""
        self.values = np.array(start, float)
        self.rates = np.zeros_like(self.values)
        self.lost_for = 0.0
        self._goal = self.values.copy()

    def step(self, wanted: Array | None, dt: float) -> Array:
        """Output after dt > 0 [s], a new array.

        Args:
            wanted: input [rad]; None, or not finite, if no person is seen: the output comes to rest at the
                last input.
        """
        if wanted is None or not np.isfinite(wanted).all():
            self.lost_for += dt
        else:
            self.lost_for = 0.0
            self._goal[:] = wanted
        fill_filtered(self._goal, self._omega, self._top_rate, dt, self.values, self.rates)
        return self.values.copy()

    def memory(self) -> tuple[Array, ...]:
        """State for the next step, as copies."""
        return self.values.copy(), self.rates.copy(), self._goal.copy(), np.array(self.lost_for)

    def remember(self, memory: tuple[Array, ...]) -> None:
        self.values, self.rates, self._goal = (array.copy() for array in memory[:3])
        self.lost_for = float(memory[3])
