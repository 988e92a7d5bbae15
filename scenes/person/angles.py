"""A person's arms as four angles each, named and ordered as in the paper.

The torso frame has x forward, y to the person's left, z up, and its origin halfway between the shoulders. For
hanging arms, palms towards the thighs, all angles are zero. From there

    flexion    swings the straight arm forward: 90° points ahead, 180° overhead, negative is behind the back;
    abduction  then lifts it sideways, away from the body: 90° is a T, whatever the flexion;
    rotation   then turns it about its own axis, outward positive: a bent forearm swings from ahead outwards;
    elbow      bends: 0° straight, 90° with the forearm ahead if all others are zero.

With s = +1 for the left arm and −1 for the right, so that mirrored arms have equal angles,

    R = Ry(−flexion) Rx(s abduction) Rz(s rotation),
    upper arm = R (0, 0, −1),   forearm = R (sin elbow, 0, −cos elbow).

The International Society of Biomechanics (for the elbow) and the drawn model use the same order of axes.

At 90° of abduction flexion and rotation turn about the same line; at a straight elbow the rotation is not
visible. There the last value is kept.
"""

import math
from typing import Final, NamedTuple

import numpy as np

from controllers.compiled import Matrix, Vector, loop
from controllers.kinematics import Array
from scenes.settings import ArmName

TRUSTED_SINE: Final = 0.1
"""From this sine of the bone's angle off an axis on, the measured angle about the axis is used unchanged."""

SIGN: Final[dict[ArmName, float]] = {"left": 1.0, "right": -1.0}


SHOULDER_WIDTH: Final = 0.42
UPPER_ARM: Final = 0.276
FOREARM: Final = 0.287
"""Shoulder to shoulder, to elbow, to wrist of the drawn model, a man of 1.8 m [m]."""


class BodyPoints(NamedTuple):
    """Tracked points of a person, in any right-handed frame and unit.

    Attributes:
        shoulders, elbows, wrists: (2, 3), left first.
        hips: (3,), halfway between the hip joints.
    """

    shoulders: Array
    elbows: Array
    wrists: Array
    hips: Array


@loop("float64(float64)")
def wrapped(angle: float) -> float:
    """The angle in −π … π."""
    return angle - math.tau * math.floor(angle / math.tau + 0.5)


@loop("float64(float64, float64, float64, float64)")
def remembered(angle: float, previous: float, sine: float, trusted: float) -> float:
    """Angle about an axis, continued from its previous value [rad].

    Args:
        angle: as measured; meaningless if `sine` is 0.
        previous: of the last sample.
        sine: of the angle between bone and axis, 0 … 1.
        trusted: sine from which `angle` is used unchanged.

    Returns:
        For a large sine the angle, in the turn nearest to the previous one; for 0 the previous one; in
        between a smooth mixture, which converges to the true value at rest.
    """
    s = min(max(sine / trusted, 0.0), 1.0)
    return previous + s * s * (3.0 - 2.0 * s) * wrapped(angle - previous)


@loop("void(float64[:], float64, float64[:, :])", fills=("R",))
def fill_arm_rotation(angles: Vector, sign: float, R: Matrix) -> None:
    """Fill R (3, 3), see `arm_rotation`. `sign`: s of the arm."""
    f, a, r = angles[0], sign * angles[1], sign * angles[2]
    cf, sf = math.cos(f), math.sin(f)
    ca, sa = math.cos(a), math.sin(a)
    cr, sr = math.cos(r), math.sin(r)
    R[0, 0], R[0, 1], R[0, 2] = cf * cr - sf * sa * sr, -cf * sr - sf * sa * cr, -sf * ca
    R[1, 0], R[1, 1], R[1, 2] = ca * sr, ca * cr, -sa
    R[2, 0], R[2, 1], R[2, 2] = sf * cr + cf * sa * sr, -sf * sr + cf * sa * cr, cf * ca


@loop("void(float64[:], float64, float64[:], float64[:])", fills=("upper", "forearm"))
def fill_directions(angles: Vector, sign: float, upper: Vector, forearm: Vector) -> None:
    """See `arm_directions`."""
    R = np.empty((3, 3))
    fill_arm_rotation(angles, sign, R)
    ce, se = math.cos(angles[3]), math.sin(angles[3])
    for i in range(3):
        upper[i] = -R[i, 2]
        forearm[i] = se * R[i, 0] - ce * R[i, 2]


def arm_rotation(angles: Array, side: ArmName) -> Array:
    """R (3, 3) of the upper arm in the torso frame. `angles`: (4,) [rad]."""
    R = np.empty((3, 3))
    fill_arm_rotation(angles, SIGN[side], R)
    return R


def arm_directions(angles: Array, side: ArmName) -> tuple[Array, Array]:
    """Unit vectors (3,) of upper arm and forearm, towards the hand, torso frame. `angles`: (4,) [rad]."""
    upper, forearm = np.empty(3), np.empty(3)
    fill_directions(angles, SIGN[side], upper, forearm)
    return upper, forearm


def direction_angles(
    upper: Array, forearm: Array, side: ArmName, previous: Array | None = None, trusted: float = TRUSTED_SINE
) -> Array:
    """Angles (4,) [rad] of an arm from the directions of its bones.

    Args:
        upper, forearm: unit vectors (3,) towards the hand, torso frame.
        previous: angles (4,) of the last sample; the result continues them and may gather whole turns.
            Without, flexion and rotation are in −π … π, abduction in ±π/2, elbow in 0 … π.
        trusted: see `remembered`; a smaller value follows closer, with faster angles.
    """
    sign = SIGN[side]
    (ux, uy, uz), (wx, wy, wz) = upper.tolist(), forearm.tolist()
    uy, wy = sign * uy, sign * wy
    before = None if previous is None else previous.tolist()
    lean = math.hypot(ux, uz)
    f = math.atan2(ux, -uz) if lean > 0.0 else 0.0
    if before is not None:
        a = math.atan2(uy, lean)
        # The same direction is reached over the top: (f, a) and (f + π, π − a).
        near = math.hypot(wrapped(f - before[0]), wrapped(a - before[1]))
        over = math.hypot(wrapped(f + math.pi - before[0]), wrapped(math.pi - a - before[1]))
        f = remembered(f if near <= over else f + math.pi, before[0], lean, trusted)
    cf, sf = math.cos(f), math.sin(f)
    a = math.atan2(uy, sf * ux - cf * uz)
    ca, sa = math.cos(a), math.sin(a)
    x, z = cf * wx + sf * wz, cf * wz - sf * wx
    y = ca * wy + sa * z
    bend = math.sqrt((uy * wz - uz * wy) ** 2 + (uz * wx - ux * wz) ** 2 + (ux * wy - uy * wx) ** 2)
    e = math.atan2(bend, ux * wx + uy * wy + uz * wz)
    r = math.atan2(y, x) if bend > 1e-12 else 0.0
    if before is not None:
        a = before[1] + wrapped(a - before[1])
        r = remembered(r, before[2], bend, trusted)
    return np.array([f, a, r, e])


def arm_points(angles: Array, side: ArmName) -> tuple[Array, Array, Array]:
    """Shoulder, elbow and wrist (3,) in the torso frame [m]. `angles`: (4,) [rad]."""
    upper, forearm = arm_directions(angles, side)
    shoulder = np.array([0.0, SIGN[side] * SHOULDER_WIDTH / 2.0, 0.0])
    elbow = shoulder + UPPER_ARM * upper
    return shoulder, elbow, elbow + FOREARM * forearm


def torso_rotation(left_shoulder: Array, right_shoulder: Array, hips: Array) -> Array | None:
    """R (3, 3) of the torso, columns forward, left, up; None if the points are on one line or not finite.

    Up is from the hips to between the shoulders.

    Args:
        left_shoulder, right_shoulder, hips: (3,), in one frame and unit.
    """
    up = _unit((left_shoulder + right_shoulder) / 2.0 - hips)
    across = _unit(left_shoulder - right_shoulder)
    if up is None or across is None:
        return None
    left = across - (across @ up) * up
    if float(left @ left) < 1e-4:
        return None
    left /= math.sqrt(float(left @ left))
    return np.column_stack([np.cross(left, up), left, up])


def body_angles(points: BodyPoints, previous: Array | None = None) -> Array | None:
    """Angles (2, 4) of both arms [rad], left first; None if the points are not a body. `previous`: (2, 4)."""
    R = torso_rotation(points.shoulders[0], points.shoulders[1], points.hips)
    if R is None:
        return None
    angles = np.empty((2, 4))
    for i, side in enumerate(SIGN):
        upper, forearm = (
            _unit(points.elbows[i] - points.shoulders[i]),
            _unit(points.wrists[i] - points.elbows[i]),
        )
        if upper is None or forearm is None:
            return None
        angles[i] = direction_angles(upper @ R, forearm @ R, side, None if previous is None else previous[i])
    return angles


def _unit(vector: Array) -> Array | None:
    length = math.sqrt(float(vector @ vector))
    return vector / length if 1e-12 < length < math.inf else None
