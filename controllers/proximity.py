"""Closest points of every pair of bodies, the critical pair, and J_d by closed form, eqs (26), (27).

With n the unit vector from the first body's closest point to the second's and p either of these points,

    ḋ = n · (ẋ_second − ẋ_first) = ±[n; p × n]ᵀ J q̇,

one row over the joints of all arms: eq. (26) for both arms at once. The normal passes through both closest
points, so their motion over the surfaces does not matter.

coal's broad phase fails for capsules: it returns the pair evaluated last.
"""

import math
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from coal import Capsule

from controllers.choices import Treatment
from controllers.compiled import IndexPairs, Matrix, Vector, loop
from controllers.convex_distance import convex_closest
from controllers.kinematics import Array, Kinematics


class Proximity(NamedTuple):
    """Distances and their gradients.

    Attributes:
        distance: true smallest distance d over all pairs, signed [m].
        law_distance: distance that the law acts on [m], never larger than d: d itself (single), or the smooth
            minimum −ln Σ exp(−β d_i) / β of the N pairs' distances (soft), at most ln(N)/β below d, or of
            their strictly convex ones (smooth), at most √(ε/2) further below.
        row: J_d (nv,), the gradient of `law_distance` by q of all arms [m/rad].
        pair_row: J_d (nv,) of the closest pair; the same array as `row` under "single".
    """

    distance: float
    pair: int
    law_distance: float
    row: Array
    pair_row: Array


@loop(
    "void(float64, float64, float64, float64, float64, float64, float64[:, :], float64[:], float64[:])",
    fills=("row",),
)
def pair_row(
    px: float,
    py: float,
    pz: float,
    nx: float,
    ny: float,
    nz: float,
    jacobian: Matrix,
    signs: Vector,
    row: Vector,
) -> None:
    """Fill n · (velocity of the second body − of the first) per q̇ (nv,), at p, eqs (26), (27).

    Args:
        px, py, pz: p on the line of contact, world [m].
        nx, ny, nz: n, from the first body to the second.
        jacobian: (6, nv), see `Kinematics`.
        signs: (nv,): −1 for a joint that moves only the first body, 1 the second, 0 both or none.
    """
    mx, my, mz = py * nz - pz * ny, pz * nx - px * nz, px * ny - py * nx
    for j in range(len(row)):
        row[j] = 0.0
        if signs[j] != 0.0:
            linear = nx * jacobian[0, j] + ny * jacobian[1, j] + nz * jacobian[2, j]
            row[j] = signs[j] * (linear + mx * jacobian[3, j] + my * jacobian[4, j] + mz * jacobian[5, j])


@loop("void(float64[:, :], float64[:, :], float64[:, :], float64[:, :], float64[:, :])", fills=("rows",))
def pair_rows(points: Matrix, directions: Matrix, jacobian: Matrix, signs: Matrix, rows: Matrix) -> None:
    for i in range(len(points)):
        p, n = points[i], directions[i]
        pair_row(p[0], p[1], p[2], n[0], n[1], n[2], jacobian, signs[i], rows[i])


@loop("float64(float64[:], float64[:, :], float64, float64[:])", fills=("row",))
def smooth_minimum(distances: Vector, rows: Matrix, beta: float, row: Vector) -> float:
    """−ln Σ exp(−β d_i) / β [m] of distances (pairs,); fills its gradient (nv,) from theirs (pairs, nv)."""
    # The least of them goes first: no exponential is too large, and one pair alone is its own minimum to the last bit.
    least = distances[0]
    for d in distances:
        least = min(least, d)
    row[:] = 0.0
    total = 0.0
    for i in range(len(distances)):
        weight = math.exp(beta * (least - distances[i]))
        total += weight
        for j in range(len(row)):
            row[j] += weight * rows[i, j]
    for j in range(len(row)):
        row[j] /= total
    return float(least - math.log(total) / beta)


@loop(
    "float64(float64[:, :], float64[:], int64[:, :], float64[:], float64, float64,"
    " float64[:, :], float64[:, :], float64[:], float64[:, :], float64[:])",
    fills=("distances", "rows", "row"),
)
def convex_proximity(
    frames: Matrix,
    halves: Vector,
    pairs: IndexPairs,
    reach: Vector,
    beta: float,
    epsilon: float,
    jacobian: Matrix,
    signs: Matrix,
    distances: Vector,
    rows: Matrix,
    row: Vector,
) -> float:
    """Return `smooth_minimum` of the strictly convex distances [m]; fill these (pairs,), their gradients
    `rows` (pairs, nv) and its gradient `row` (nv,) [m/rad].

    Args:
        frames: axis and centre of every body (bodies, 6), world [m].
        halves: half lengths of the axes (bodies,) [m].
        pairs: of bodies (pairs, 2).
        reach: sums of their radii (pairs,) [m].
        beta, epsilon: β [1/m], ε [m²].
        jacobian, signs: as in `pair_row`, signs (pairs, nv).
    """
    inside = math.sqrt(0.5 * epsilon)
    for i in range(len(pairs)):
        a, b = int(pairs[i, 0]), int(pairs[i, 1])
        px, py, pz, gx, gy, gz, D = convex_closest(frames[a], frames[b], halves[a], halves[b], epsilon)
        distances[i] = D - inside - reach[i]
        pair_row(px, py, pz, gx / D, gy / D, gz / D, jacobian, signs[i], rows[i])
    return smooth_minimum(distances, rows, beta, row)


def pair_signs(kinematics: Kinematics, geometry: pin.GeometryModel) -> Array:
    """Signs for `pair_row` of every pair (pairs, nv)."""
    signs = np.zeros((len(geometry.collisionPairs), kinematics.model.nv))
    for row, pair in zip(signs, geometry.collisionPairs, strict=True):
        for body, sign in ((pair.first, -1.0), (pair.second, 1.0)):
            for joint in kinematics.model.supports[geometry.geometryObjects[body].parentJoint]:
                if joint:
                    moved = kinematics.model.joints[joint]
                    row[moved.idx_v : moved.idx_v + moved.nv] += sign
    return signs


class ConvexPairs:
    """Strictly convex distances of the pairs of a geometry, and their smooth minimum.

    Args:
        geometry: at least one pair, of capsules or spheres.
        data: of the geometry; `fill` reads its placements.
        signs: columns `joints` of `pair_signs` (pairs, n).
    """

    def __init__(
        self,
        kinematics: Kinematics,
        geometry: pin.GeometryModel,
        data: pin.GeometryData,
        signs: Array,
        joints: slice = slice(None),
    ) -> None:
        bodies, count = geometry.geometryObjects, len(geometry.collisionPairs)
        self._pairs = np.array(
            [(pair.first, pair.second) for pair in geometry.collisionPairs], np.int64
        ).reshape(-1, 2)
        radii = np.array([body.geometry.radius for body in bodies])
        self._reach = radii[self._pairs].sum(axis=1)
        self._halves = np.array(
            [body.geometry.halfLength if isinstance(body.geometry, Capsule) else 0.0 for body in bodies]
        )
        # Live views of Pinocchio's memory, so that one call brings axes and centres together.
        self._placed = [
            view for placement in data.oMg for view in (placement.rotation[:, 2], placement.translation)
        ]
        self._frames = np.empty((len(bodies), 6))
        self._distances, self._rows = np.empty(count), np.empty(signs.shape)
        self._jacobian, self._signs = kinematics.jacobian[:, joints], signs

    def fill(self, beta: float, epsilon: float, row: Array) -> float:
        """`smooth_minimum` [m]; fills its gradient (n,) [m/rad]."""
        np.concatenate(self._placed, out=self._frames.reshape(-1))
        bodies, moving = (self._frames, self._halves, self._pairs, self._reach), (self._jacobian, self._signs)
        return convex_proximity(*bodies, beta, epsilon, *moving, self._distances, self._rows, row)


class ProximityDetector:
    """Distances and their gradients for a fixed set of pairs.

    Args:
        geometry: bodies and pairs. Without pairs d = ∞, J_d = 0, pair −1.
    """

    def __init__(self, kinematics: Kinematics, geometry: pin.GeometryModel) -> None:
        self.kinematics = kinematics
        self.geometry = geometry
        self.data = geometry.createData()
        count, nv = len(geometry.collisionPairs), kinematics.model.nv
        nothing = np.zeros(nv)
        self._nothing = Proximity(math.inf, -1, math.inf, nothing, nothing)
        self.pair_names: tuple[tuple[str, str], ...] = tuple(
            (geometry.geometryObjects[p.first].name, geometry.geometryObjects[p.second].name)
            for p in geometry.collisionPairs
        )
        self._results = [self.data.distanceResults[i] for i in range(count)]
        self._normals = [result.normal for result in self._results]
        self._first_points = [result.getNearestPoint1 for result in self._results]
        self._signs = pair_signs(kinematics, geometry)
        self._convex = ConvexPairs(kinematics, geometry, self.data, self._signs)
        self._rows = np.empty((count, nv))

    @property
    def count(self) -> int:
        return len(self._results)

    def detect(
        self, treatment: Treatment = "single", beta: float = 100.0, epsilon: float = 1e-4
    ) -> Proximity:
        """Proximity at the last `kinematics.update`.

        Args:
            beta: β [1/m]; not for "single".
            epsilon: ε [m²]; only for "smooth".
        """
        if not self.count:
            return self._nothing
        kinematics = self.kinematics
        pin.updateGeometryPlacements(kinematics.model, kinematics.data, self.geometry, self.data)
        pair = pin.computeDistances(self.geometry, self.data)
        distance, closest = self._results[pair].min_distance, self.row(pair)
        if treatment == "single":
            return Proximity(distance, pair, distance, closest, closest)
        row = np.empty(len(closest))
        if treatment == "soft":
            self._fill_rows(self._rows)
            law_distance = smooth_minimum(self.distances(), self._rows, beta, row)
        else:
            law_distance = self._convex.fill(beta, epsilon, row)
        # Until the loop is compiled it returns a number of numpy's.
        return Proximity(distance, pair, law_distance, row, closest)

    def row(self, pair: int) -> Array:
        """J_d (nv,) of one pair at the last `detect`."""
        result, row = self._results[pair], np.empty(self._signs.shape[1])
        px, py, pz = result.getNearestPoint1().tolist()
        nx, ny, nz = result.normal.tolist()
        pair_row(px, py, pz, nx, ny, nz, self.kinematics.jacobian, self._signs[pair], row)
        return row

    def rows(self) -> Array:
        """J_d of every pair (pairs, nv) at the last `detect`."""
        rows = np.empty(self._signs.shape)
        self._fill_rows(rows)
        return rows

    def distances(self) -> Array:
        """Signed distance of every pair (pairs,) at the last `detect` [m]."""
        return np.array([result.min_distance for result in self._results])

    def witness_points(self, pair: int) -> tuple[Array, Array]:
        """Closest points (3,) on the pair's two bodies, world [m]."""
        result = self._results[pair]
        return result.getNearestPoint1(), result.getNearestPoint2()

    def _fill_rows(self, rows: Array) -> None:
        points = np.concatenate([point() for point in self._first_points]).reshape(-1, 3)
        pair_rows(
            points, np.concatenate(self._normals).reshape(-1, 3), self.kinematics.jacobian, self._signs, rows
        )
