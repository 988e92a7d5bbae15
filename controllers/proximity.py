"""Closest points of every pair of bodies, the critical pair, and J_d by closed form, eqs (26), (27).

Distances come from one C++ call, `pinocchio.computeDistances`, which keeps one result a pair. (coal's broad phase must not be used
for capsules: it returns the pair evaluated last.) With n the unit vector from the first body's closest point to the second's and p
either of these points,

    ḋ = n · (ẋ_second − ẋ_first) = ±[n; p × n]ᵀ J q̇,

one row over the joints of all arms: eq. (26) for either arm at once. At the closest points the normal passes through both, so it
does not matter which of the two p is, nor that the points travel over the surfaces.
"""

import math
from typing import Final, NamedTuple

import numpy as np
import pinocchio as pin

from controllers.choices import Treatment
from controllers.convex_distance import ConvexDistances
from controllers.kinematics import Array, Kinematics

CROSS: Final = np.zeros((12, 6))
"""From a direction n and the nine products p_i n_j, in a row of 12, to the wrench (n, p × n) by a product with this matrix."""
CROSS[(0, 1, 2), (0, 1, 2)] = 1.0
CROSS[(8, 9, 4), (3, 4, 5)] = 1.0
CROSS[(10, 5, 6), (3, 4, 5)] = -1.0


class Proximity(NamedTuple):
    """How near the bodies are.

    Attributes:
        distance: true smallest distance d over all pairs, signed [m].
        pair: index of the closest pair.
        law_distance: the distance the law acts on [m]: d itself (single), or the smooth minimum −ln Σ exp(−β d_i) / β of the N
            pairs' distances (soft), at most ln(N)/β below d, or of their strictly convex ones (smooth), at most √(ε/2) further below.
            It is never larger than d.
        row: J_d (nv,), the gradient of `law_distance` with respect to q of all arms [m/rad].
        pair_row: J_d (nv,) of the closest pair; the same array as `row` under "single".
    """

    distance: float
    pair: int
    law_distance: float
    row: Array
    pair_row: Array


class ProximityDetector:
    """Distances and their gradients for a fixed set of pairs.

    Args:
        kinematics: the arms; its `update` must be called before `detect`.
        geometry: bodies and pairs (the pairs already chosen). Without a pair nothing is near: d = ∞, J_d = 0, pair −1.
    """

    def __init__(self, kinematics: Kinematics, geometry: pin.GeometryModel) -> None:
        self.kinematics = kinematics
        self.geometry = geometry
        self.data = geometry.createData()
        count, nv = len(geometry.collisionPairs), kinematics.model.nv
        nothing = np.zeros(nv)
        self._nothing = Proximity(math.inf, -1, math.inf, nothing, nothing)
        self.pair_names: tuple[tuple[str, str], ...] = tuple(
            (geometry.geometryObjects[p.first].name, geometry.geometryObjects[p.second].name) for p in geometry.collisionPairs
        )
        self._results = [self.data.distanceResults[i] for i in range(count)]
        self._normals = [result.normal for result in self._results]
        self._first_points = [result.getNearestPoint1 for result in self._results]
        self._signs = np.zeros((count, nv))
        for signs, pair in zip(self._signs, geometry.collisionPairs, strict=True):
            for body, sign in ((pair.first, -1.0), (pair.second, 1.0)):
                for joint in kinematics.model.supports[geometry.geometryObjects[body].parentJoint]:
                    if joint:
                        moved = kinematics.model.joints[joint]
                        signs[moved.idx_v : moved.idx_v + moved.nv] += sign
        self._sign_rows = list(self._signs)
        self._wrench = np.empty(6)
        self._row = np.empty(nv)
        self._directions_and_products = np.empty((4, 3, count))
        self._rows = np.empty((count, nv))
        self._ones = np.ones(count)
        self._convex = ConvexDistances(geometry, self.data) if count else None

    @property
    def count(self) -> int:
        """Number of pairs."""
        return len(self._results)

    def detect(self, treatment: Treatment = "single", beta: float = 100.0, epsilon: float = 1e-4) -> Proximity:
        """Return the proximity at the configuration of the last `kinematics.update`.

        Args:
            treatment: see `Treatment`.
            beta: β of the smooth minimum [1/m]; unused for "single".
            epsilon: ε of the strictly convex distance [m²]; used for "smooth" alone.
        """
        if self._convex is None:
            return self._nothing
        kinematics = self.kinematics
        pin.updateGeometryPlacements(kinematics.model, kinematics.data, self.geometry, self.data)
        pair = pin.computeDistances(self.geometry, self.data)
        distance = self._results[pair].min_distance
        if treatment == "single":
            row = self.row(pair)
            return Proximity(distance, pair, distance, row, row)
        if treatment == "soft":
            law_distance, weights = self._smooth_minimum(self.distances(), beta)
            rows = self._all_rows()
            return Proximity(distance, pair, law_distance, weights.dot(rows), rows[pair])
        convex = self._convex
        law_distance, weights = self._smooth_minimum(convex.update(epsilon), beta)
        rows = self._rows_along(convex.gaps, convex.points)
        weights /= convex.lengths
        return Proximity(distance, pair, law_distance, weights.dot(rows), self.row(pair))

    def row(self, pair: int) -> Array:
        """Return J_d (nv,) of one pair at the last `detect`, a fresh array."""
        result = self._results[pair]
        nx, ny, nz = result.normal.tolist()
        px, py, pz = result.getNearestPoint1().tolist()
        self._wrench[:] = (nx, ny, nz, py * nz - pz * ny, pz * nx - px * nz, px * ny - py * nx)
        return self._wrench.dot(self.kinematics.jacobian, self._row) * self._sign_rows[pair]

    def rows(self) -> Array:
        """Return J_d of every pair (pairs, nv) at the last `detect`, a copy."""
        return self._all_rows().copy()

    def distances(self) -> Array:
        """Return the signed distance of every pair (pairs,) at the last `detect` [m], a copy."""
        return np.array([result.min_distance for result in self._results])

    def witness_points(self, pair: int) -> tuple[Array, Array]:
        """Return the closest points (3,) on the pair's first and second body, world [m]."""
        result = self._results[pair]
        return result.getNearestPoint1(), result.getNearestPoint2()

    def direction(self, pair: int) -> Array:
        """Return the unit vector (3,) from the pair's first to its second body at the last `detect`, a copy."""
        return self._results[pair].normal.copy()

    def _smooth_minimum(self, distances: Array, beta: float) -> tuple[float, Array]:
        """Return −ln Σ exp(−β d_i) / β [m], and its derivatives with respect to d (pairs,), which add up to 1; overwrites d."""
        # The least of them goes first: no exponential is too large, and one pair alone is its own minimum to the last bit.
        least = distances.item(distances.argmin())
        distances -= least
        distances *= -beta
        np.exp(distances, distances)
        total = float(self._ones.dot(distances))
        distances *= 1.0 / total
        return least - math.log(total) / beta, distances

    def _all_rows(self) -> Array:
        points = np.concatenate([point() for point in self._first_points]).reshape(-1, 3)
        return self._rows_along(np.concatenate(self._normals).reshape(-1, 3).T, points.T)

    def _rows_along(self, directions: Array, points: Array) -> Array:
        """Return direction · (velocity of the second body − of the first) per q̇, one row a pair; both bodies' material at the point.

        Args:
            directions: (3, pairs).
            points: (3, pairs) on the lines of contact [m].
        """
        parts = self._directions_and_products
        parts[0] = directions
        np.multiply(points[:, None], directions, out=parts[1:])
        parts.reshape(12, -1).T.dot(CROSS.dot(self.kinematics.jacobian), self._rows)
        self._rows *= self._signs
        return self._rows
