"""Points of an arm on one side of a plane: a wall, a table or the floor.

    m_k = n · (p_k − o) − r_k,      h = −ln Σ exp(−β m_k) / β,      J_a = Σ p_k nᵀ J_k,

with the unit normal n, a point o of the plane, and the radius r_k about the point p_k. For a plane that moves
with the velocity ȯ and turns with ω,

    w = −∂h/∂t = Σ p_k [n · ȯ − (ω × n) · (p_k − o)].

J_a vanishes only where no joint moves the nearest point along n, for example straight above the shoulder of a
stretched arm.

Source: x_a of Petrič & Žlajpah 2011 for the virtual wall of Khatib, Int. J. Robotics Research 5(1), 1986.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
import pinocchio as pin

from controllers.compiled import Indices, Matrix, Vector, loop
from controllers.first_tasks.first_task import FirstTask, Margin
from controllers.first_tasks.joint_placements import JointPlacements
from controllers.kinematics import Arm, Array, Kinematics

SHARPNESS: Final = 100.0
"""β [1/m]: for three points h is at most 11 mm below the least distance."""


@dataclass(frozen=True, eq=False)
class ArmPoint:
    """A point that moves with a joint.

    Attributes:
        joint: id in the model.
        place: in the frame of the joint (3,) [m].
        radius: about the point [m].
    """

    joint: int
    place: Array
    radius: float = 0.0


def landmarks(model: pin.Model, arm: Arm, radius: float = 0.0) -> tuple[ArmPoint, ...]:
    """Elbow, wrist and hand of an arm; `radius` about each [m]."""
    hand, centre = model.frames[arm.hand], np.zeros(3)
    return (
        ArmPoint(arm.elbow, centre, radius),
        ArmPoint(arm.wrist, centre, radius),
        ArmPoint(hand.parentJoint, hand.placement.translation.copy(), radius),
    )


def _at_rest() -> Array:
    return np.zeros(3)


@dataclass(frozen=True, eq=False)
class Plane:
    """A plane that may move; the arm stays on the side of the normal.

    Attributes:
        normal: n (3,), of length 1, world.
        point: o (3,), world [m].
        velocity: ȯ (3,) [m/s].
        turning: ω (3,) about o [rad/s].
    """

    normal: Array
    point: Array
    velocity: Array = field(default_factory=_at_rest)
    turning: Array = field(default_factory=_at_rest)

    def numbers(self) -> Array:
        """n, o, ȯ and ω concatenated (12,)."""
        return np.concatenate((self.normal, self.point, self.velocity, self.turning))


@loop(
    "UniTuple(float64, 2)(float64[:, :], float64[:, :], float64[:], int64[:], float64[:, :], float64[:], float64, float64[:])",
    fills=("row",),
)
def points_over_plane(
    placements: Matrix,
    places: Matrix,
    radii: Vector,
    moving: Indices,
    jacobian: Matrix,
    plane: Vector,
    beta: float,
    row: Vector,
) -> tuple[float, float]:
    """h [m] and w [m/s]; fills J_a (n,) [m/rad].

    Args:
        placements, moving: of the points' joints, see `JointPlacements`.
        places, radii: of the points in the frames of their joints (k, 3), (k,) [m].
        jacobian: the arm's columns (6, n), see `Kinematics`.
        plane: see `Plane.numbers` (12,).
        beta: β [1/m].
    """
    count, n = len(places), len(row)
    nx, ny, nz = plane[0], plane[1], plane[2]
    # n turns at ω × n.
    tx, ty, tz = (
        plane[10] * nz - plane[11] * ny,
        plane[11] * nx - plane[9] * nz,
        plane[9] * ny - plane[10] * nx,
    )
    moved = nx * plane[6] + ny * plane[7] + nz * plane[8]
    points, margins = np.empty((count, 3)), np.empty(count)
    least = math.inf
    for k in range(count):
        M, place = placements[k], places[k]
        for i in range(3):
            points[k, i] = M[i] * place[0] + M[3 + i] * place[1] + M[6 + i] * place[2] + M[9 + i]
        x, y, z = points[k, 0] - plane[3], points[k, 1] - plane[4], points[k, 2] - plane[5]
        margins[k] = nx * x + ny * y + nz * z - radii[k]
        least = min(least, margins[k])
    row[:] = 0.0
    total = approach = 0.0
    for k in range(count):
        weight = math.exp(beta * (least - margins[k]))
        total += weight
        px, py, pz = points[k, 0], points[k, 1], points[k, 2]
        mx, my, mz = py * nz - pz * ny, pz * nx - px * nz, px * ny - py * nx
        for j in range(moving[k]):
            linear = nx * jacobian[0, j] + ny * jacobian[1, j] + nz * jacobian[2, j]
            row[j] += weight * (linear + mx * jacobian[3, j] + my * jacobian[4, j] + mz * jacobian[5, j])
        turned = tx * (px - plane[3]) + ty * (py - plane[4]) + tz * (pz - plane[5])
        approach += weight * (moved - turned)
    for j in range(n):
        row[j] /= total
    return least - math.log(total) / beta, approach / total


class PointsOverPlane(FirstTask):
    """h: smooth minimum of the distances of points of the arm from a plane [m].

    Args:
        points: at least one, for example `landmarks`.
        plane: may be set later.
    """

    name = "distance from a plane"
    unit = "m"

    def __init__(
        self,
        kinematics: Kinematics,
        arm: Arm,
        points: Sequence[ArmPoint],
        plane: Plane,
        critical_value: float = 0.05,
        nominal_rate: float = 0.3,
    ) -> None:
        super().__init__(critical_value, nominal_rate)
        self._placements = JointPlacements(kinematics, arm, [point.joint for point in points])
        self._places = np.array([point.place for point in points])
        self._radii = np.array([point.radius for point in points])
        self._jacobian = kinematics.jacobian[:, arm.joints]
        self.plane = plane

    @property
    def plane(self) -> Plane:
        return self._plane

    @plane.setter
    def plane(self, plane: Plane) -> None:
        self._plane, self._numbers = plane, plane.numbers()

    def margin(self) -> Margin:
        placed, row = self._placements, np.empty(self._jacobian.shape[1])
        points = placed.read(), self._places, self._radii, placed.moving
        h, w = points_over_plane(*points, self._jacobian, self._numbers, SHARPNESS, row)
        return Margin(h, row, w)

    def nearest_point(self) -> Array:
        """Point (3,) of the arm's surface nearest to the plane, world [m]."""
        plane, placed = self._plane, self._placements.read()
        points = np.array(
            [M[:9].reshape(3, 3).T @ place + M[9:] for M, place in zip(placed, self._places, strict=True)]
        )
        points -= plane.normal * self._radii[:, np.newaxis]
        nearest: Array = points[int((points @ plane.normal).argmin())]
        return nearest
