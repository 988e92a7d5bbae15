"""Links of an arm over fixed boxes: a bench, a floor.

The distance of a capsule from a box has a kink where its axis is parallel to a face. As in
`controllers.convex_distance` a strictly convex problem avoids it. With the signed distance b of a point from
the box, a convex function, the capsule's centre c, half axis a and radius r,

    m = min over s in [−1, 1] of b(c + s a) + (κ/4)(s² − 1) − r,      ∂m/∂q = ∇b(P)ᵀ J_P at P = c + s a,

so that m is 0 to κ/4 below the true distance, and differentiable wherever the axis is outside the box. h is
the smooth minimum of m over all capsules and boxes.

Source: ours; x_a of Petrič & Žlajpah 2011 for what Sugiura et al. (IROS 2007) do between the links.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from controllers.compiled import Indices, Matrix, Vector, loop
from controllers.first_tasks.first_task import FirstTask, Margin
from controllers.first_tasks.joint_placements import JointPlacements
from controllers.kinematics import Arm, Array, Kinematics

SHARPNESS: Final = 100.0
"""β [1/m]."""

ROUNDING: Final = 0.010
"""κ [m]: at most 2.5 mm of distance."""

HALVINGS: Final = 40
"""Bisections for s: the interval left is below 1e-11."""


@dataclass(frozen=True, eq=False)
class LinkCapsule:
    """A capsule that moves with a joint (id); centre and half axis (3,) in its frame, and radius [m]."""

    joint: int
    centre: Array
    half_axis: Array
    radius: float


@loop("UniTuple(float64, 4)(float64, float64, float64, float64[:])")
def box_distance(px: float, py: float, pz: float, box: Vector) -> tuple[float, float, float, float]:
    """Signed distance of a point from a box [m], and its gradient; `box`: centre and half sizes (6,), world
    [m].
    """
    x, y, z = px - box[0], py - box[1], pz - box[2]
    ax, ay, az = abs(x) - box[3], abs(y) - box[4], abs(z) - box[5]
    sx, sy, sz = (1.0 if x >= 0.0 else -1.0), (1.0 if y >= 0.0 else -1.0), (1.0 if z >= 0.0 else -1.0)
    ox, oy, oz = max(ax, 0.0), max(ay, 0.0), max(az, 0.0)
    outside = math.sqrt(ox * ox + oy * oy + oz * oz)
    if outside > 0.0:
        return outside, sx * ox / outside, sy * oy / outside, sz * oz / outside
    if az >= ax and az >= ay:
        return az, 0.0, 0.0, sz
    if ax >= ay:
        return ax, sx, 0.0, 0.0
    return ay, 0.0, sy, 0.0


@loop("float64(float64, float64, float64, float64, float64, float64, float64, float64, float64[:])")
def slope_along(
    cx: float, cy: float, cz: float, ax: float, ay: float, az: float, s: float, kappa: float, box: Vector
) -> float:
    """Derivative by s of the minimised function [m]; see `capsule_over_box`."""
    _, gx, gy, gz = box_distance(cx + s * ax, cy + s * ay, cz + s * az, box)
    return gx * ax + gy * ay + gz * az + 0.5 * kappa * s


@loop(
    "UniTuple(float64, 7)(float64, float64, float64, float64, float64, float64, float64, float64, float64[:])",
)
def capsule_over_box(
    cx: float, cy: float, cz: float, ax: float, ay: float, az: float, radius: float, kappa: float, box: Vector
) -> tuple[float, float, float, float, float, float, float]:
    """m of a capsule and a box [m], the point P on the axis, world [m], and ∇b there.

    Args:
        cx, cy, cz, ax, ay, az: centre and half axis, world [m].
        radius, kappa: [m].
        box: see `box_distance`.
    """
    low, high = -1.0, 1.0
    # Mostly an end is the nearest.
    if slope_along(cx, cy, cz, ax, ay, az, 1.0, kappa, box) <= 0.0:
        low = 1.0
    elif slope_along(cx, cy, cz, ax, ay, az, -1.0, kappa, box) >= 0.0:
        high = -1.0
    else:
        for _ in range(HALVINGS):
            s = 0.5 * (low + high)
            if slope_along(cx, cy, cz, ax, ay, az, s, kappa, box) > 0.0:
                high = s
            else:
                low = s
    s = 0.5 * (low + high)
    px, py, pz = cx + s * ax, cy + s * ay, cz + s * az
    d, gx, gy, gz = box_distance(px, py, pz, box)
    return d + 0.25 * kappa * (s * s - 1.0) - radius, px, py, pz, gx, gy, gz


@loop(
    "float64(float64[:, :], float64[:, :], float64[:], int64[:], float64[:, :], float64[:, :], float64, float64, float64[:])",
    fills=("row",),
)
def links_over_boxes(
    placements: Matrix,
    capsules: Matrix,
    radii: Vector,
    moving: Indices,
    boxes: Matrix,
    jacobian: Matrix,
    beta: float,
    kappa: float,
    row: Vector,
) -> float:
    """h [m]; fills J_a (n,) [m/rad].

    Args:
        placements, moving: of the capsules' joints, see `JointPlacements`.
        capsules, radii: centre and half axis in the joint's frame (k, 6) [m], and (k,) [m].
        boxes: centres and half sizes (b, 6), world [m].
        jacobian: the arm's columns (6, n), see `Kinematics`.
        beta, kappa: β [1/m], κ [m].
    """
    count, n = len(capsules) * len(boxes), len(row)
    margins, lines = np.empty(count), np.empty((count, 6))
    least, at = math.inf, 0
    for k in range(len(capsules)):
        M, own = placements[k], capsules[k]
        cx = M[0] * own[0] + M[3] * own[1] + M[6] * own[2] + M[9]
        cy = M[1] * own[0] + M[4] * own[1] + M[7] * own[2] + M[10]
        cz = M[2] * own[0] + M[5] * own[1] + M[8] * own[2] + M[11]
        ax = M[0] * own[3] + M[3] * own[4] + M[6] * own[5]
        ay = M[1] * own[3] + M[4] * own[4] + M[7] * own[5]
        az = M[2] * own[3] + M[5] * own[4] + M[8] * own[5]
        for b in range(len(boxes)):
            m, px, py, pz, gx, gy, gz = capsule_over_box(cx, cy, cz, ax, ay, az, radii[k], kappa, boxes[b])
            margins[at], least = m, min(least, m)
            lines[at, 0], lines[at, 1], lines[at, 2] = gx, gy, gz
            lines[at, 3], lines[at, 4], lines[at, 5] = py * gz - pz * gy, pz * gx - px * gz, px * gy - py * gx
            at += 1
    row[:] = 0.0
    total = 0.0
    for i in range(count):
        weight, line = math.exp(beta * (least - margins[i])), lines[i]
        total += weight
        for j in range(moving[i // len(boxes)]):
            along = line[0] * jacobian[0, j] + line[1] * jacobian[1, j] + line[2] * jacobian[2, j]
            row[j] += weight * (
                along + line[3] * jacobian[3, j] + line[4] * jacobian[4, j] + line[5] * jacobian[5, j]
            )
    for j in range(n):
        row[j] /= total
    return float(least - math.log(total) / beta)


class LinksOverBoxes(FirstTask):
    """h: smooth minimum of the distances of an arm's capsules from fixed boxes [m].

    Args:
        capsules: at least one.
        boxes: centres and half sizes (b, 6), at least one, world axes [m].
    """

    name = "distance from boxes"
    unit = "m"

    def __init__(
        self,
        kinematics: Kinematics,
        arm: Arm,
        capsules: Sequence[LinkCapsule],
        boxes: Array,
        critical_value: float = 0.03,
        nominal_rate: float = 0.1,
    ) -> None:
        super().__init__(critical_value, nominal_rate)
        self._placements = JointPlacements(kinematics, arm, [capsule.joint for capsule in capsules])
        self._capsules = np.array([[*capsule.centre, *capsule.half_axis] for capsule in capsules])
        self._radii = np.array([capsule.radius for capsule in capsules])
        self._boxes, self._jacobian = boxes, kinematics.jacobian[:, arm.joints]

    def margin(self) -> Margin:
        placed, row = self._placements, np.empty(self._jacobian.shape[1])
        links = placed.read(), self._capsules, self._radii, placed.moving
        return Margin(links_over_boxes(*links, self._boxes, self._jacobian, SHARPNESS, ROUNDING, row), row)
