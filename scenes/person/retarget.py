"""From a person's arms to a robot's: joints 1 … 4 of an LWR that make its upper arm and forearm point where the person's do.

The first three axes of the LWR, z, −y, z, meet in the shoulder; the fourth, +y, is the elbow (`scenes.lwr.facts`). With ū and f̄ the
directions of the person's upper arm and forearm in the frame of the robot's base, the joints solve

    ū = Rz(q1) Ry(−q2) ẑ,      w = [Rz(q1) Ry(−q2)]ᵀ f̄ = Rz(q3) Ry(q4) ẑ,

so that, with σ and ε = ±1 for the four branches,

    q1 = atan2(−σ ū_y, −σ ū_x),  q2 = σ acos ū_z,  q3 = atan2(ε w_y, ε w_x),  q4 = ε acos w_z.

q1 is undefined where the upper arm lies on the base's axis, q3 where the forearm lies on the upper arm's; there the value of the
sample before is kept, and q2 and q4 do the best that is possible with it. Joints stay inside their limits in the same manner: each
joint in turn is brought inside, and the next one does its best with that.
"""

import math
from typing import Final

import numpy as np

from controllers.kinematics import Array
from scenes.lwr.facts import JOINTS
from scenes.person.angles import SIGN, arm_directions, remembered, wrapped
from scenes.rigs import RIGS, Rig

DRIVEN: Final = 4
"""Joints of an arm that the person drives: the first so many."""

LIMIT_MARGIN: Final = float(np.radians(3.0))
"""Desired joints keep so far from their stops [rad]."""

TRUSTED_SINE: Final = 0.05
"""q1 and q3 are taken as they are when the bone stands off the axis by at least this sine."""

EXACT: Final = 1e-9
"""Directions missed by less count as met [rad]."""

NATURAL: Final = (1.0, 1.0)
"""σ and ε of the branch in which ordinary gestures stay far from all stops on the torso; q2 and q4 are positive in it."""

_BRANCHES: Final = (NATURAL, (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0))

_LIMITS: Final = tuple(joint.position_limit - LIMIT_MARGIN for joint in JOINTS[:DRIVEN])


def arm_joints(upper: Array, forearm: Array, base_rotation: Array, previous: Array | None = None) -> Array:
    """Return q1 … q4 (4,) [rad] of one LWR, the branch nearest to the sample before among those that miss nothing.

    Args:
        upper, forearm: unit vectors (3,) towards the hand, world.
        base_rotation: R (3, 3) of the robot's base in the world.
        previous: q1 … q4 of the sample before (4,); without, the natural branch is preferred.
    """
    u, f = (upper @ base_rotation).tolist(), (forearm @ base_rotation).tolist()
    before = None if previous is None else previous.tolist()
    best, least = None, (math.inf, math.inf)
    for branch in _BRANCHES:
        joints, miss = _solution(u, f, branch, before)
        way = 0.0 if before is None else sum((a - b) ** 2 for a, b in zip(joints, before, strict=True))
        # Where every branch misses, one that misses a little less is not worth a leap across the room.
        rank = (0.0, way) if miss < EXACT else (1.0, miss + 0.05 * way)
        if rank < least:
            best, least = joints, rank
    return np.array(best)


def _solution(
    u: list[float], f: list[float], branch: tuple[float, float], before: list[float] | None
) -> tuple[tuple[float, ...], float]:
    """Return q1 … q4 of a branch [rad], and how far upper arm and forearm, together, point past the person's [rad]."""
    q1, q2, miss_upper = _pan_tilt(u[0], u[1], u[2], branch[0], -1.0, _LIMITS[:2], None if before is None else before[0])
    c1, s1, c2, s2 = math.cos(q1), math.sin(q1), math.cos(q2), math.sin(q2)
    x, wy = c1 * f[0] + s1 * f[1], c1 * f[1] - s1 * f[0]
    wx, wz = c2 * x + s2 * f[2], c2 * f[2] - s2 * x
    q3, q4, miss_forearm = _pan_tilt(wx, wy, wz, branch[1], 1.0, _LIMITS[2:], None if before is None else before[2])
    return (q1, q2, q3, q4), miss_upper + miss_forearm


def _pan_tilt(
    x: float, y: float, z: float, branch: float, sense: float, limits: tuple[float, ...], before: float | None
) -> tuple[float, float, float]:
    """Return a pan about z and a tilt after it that point at (x, y, z), and by how much they miss it [rad].

    Args:
        x, y, z: a unit vector.
        branch: the sign that the tilt should have.
        sense: +1 if a positive tilt leans towards +x at pan = 0, −1 if towards −x.
        limits: of pan and tilt [rad].
        before: pan of the sample before [rad].
    """
    pan_limit, tilt_limit = limits
    lean = math.hypot(x, y)
    toward = branch * sense
    pan = math.atan2(toward * y, toward * x) if lean > 1e-12 else before or 0.0
    if before is not None:
        pan = remembered(pan, before, lean, TRUSTED_SINE)
        if abs(wrapped(pan)) <= pan_limit:
            pan = wrapped(pan)
    pan = min(max(pan, -pan_limit), pan_limit)
    cp, sp = math.cos(pan), math.sin(pan)
    ahead, aside = sense * (cp * x + sp * y), cp * y - sp * x
    best = math.atan2(ahead, z)
    tilt = min(max(best, -tilt_limit), tilt_limit)
    reach, short = math.hypot(ahead, z), best - tilt
    return pan, tilt, math.atan2(math.hypot(aside, reach * math.sin(short)), reach * math.cos(short))


def natural_pose(angles: Array, rig: Rig = RIGS["torso"]) -> Array:
    """Return q1 … q4 of both robots (2, 4) [rad] that show a person's angles (2, 4) [rad], in the natural branch if limits allow."""
    return Retargeter(rig).joints(angles)


class Retargeter:
    """A person's angles, in the world's frame (x forward, y left, z up) → joints of both robots, going on from the sample before.

    Args:
        rig: where the robots stand.
    """

    def __init__(self, rig: Rig = RIGS["torso"]) -> None:
        self._bases = (rig.left_base.rotation.copy(), rig.right_base.rotation.copy())
        self._previous: Array | None = None

    def reset(self, joints: Array | None = None) -> None:
        """Continue from these q1 … q4 (2, 4) [rad], or choose again."""
        self._previous = None if joints is None else joints.copy()

    def joints(self, angles: Array) -> Array:
        """Return q1 … q4 of both robots (2, 4) [rad], left robot first, inside their limits.

        Args:
            angles: of the person (2, 4) [rad], the person's left arm first.
        """
        wanted = np.empty((2, DRIVEN))
        for i, side in enumerate(SIGN):
            upper, forearm = arm_directions(angles[i], side)
            wanted[i] = arm_joints(upper, forearm, self._bases[i], None if self._previous is None else self._previous[i])
        self._previous = wanted
        return wanted.copy()

    def memory(self) -> tuple[Array, ...]:
        """Return q1 … q4 of the sample before (2, 4) [rad], nothing if there was none."""
        return () if self._previous is None else (self._previous.copy(),)

    def remember(self, memory: tuple[Array, ...]) -> None:
        self.reset(memory[0] if memory else None)
