"""Closest points of every pair of bodies, the critical pair, and J_d by closed form, eqs (26), (27).

Distances come from one C++ call, `pinocchio.computeDistances`, which keeps one result a pair. (coal's broad phase must not be used
for capsules: it returns the pair evaluated last.) With n the unit vector from the first body's closest point to the second's and p
either of these points,

    ḋ = n · (ẋ_second − ẋ_first) = ±[n; p × n]ᵀ J q̇,

one row over the joints of all arms: eq. (26) for either arm at once. At the closest points the normal passes through both, so it
does not matter which of the two p is, nor that the points travel over the surfaces.
"""

import math
from typing import Literal, NamedTuple

import numpy as np
import pinocchio as pin

from controllers.kinematics import Array, Kinematics

Treatment = Literal["single", "soft"]
"""What the law sees of the pairs: the closest one (the paper), or a smooth minimum over all (ours)."""


class Proximity(NamedTuple):
    """How near the bodies are.

    Attributes:
        distance: true smallest distance d over all pairs, signed [m].
        pair: index of the closest pair.
        law_distance: the distance the law acts on [m]: d itself (single), or the smooth minimum −ln Σ exp(−β d_i) / β (soft),
            which is never larger than d and at most ln(N)/β smaller, N the number of pairs.
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
        self._nothing = Proximity(math.inf, -1, math.inf, nothing, nothing) if count == 0 else None
        self.pair_names: tuple[tuple[str, str], ...] = tuple(
            (geometry.geometryObjects[p.first].name, geometry.geometryObjects[p.second].name) for p in geometry.collisionPairs
        )
        self._results = [self.data.distanceResults[i] for i in range(count)]
        self._normals = [result.normal for result in self._results]
        self._signs = np.zeros((count, nv))
        for signs, pair in zip(self._signs, geometry.collisionPairs, strict=True):
            for body, sign in ((pair.first, -1.0), (pair.second, 1.0)):
                for joint in kinematics.model.supports[geometry.geometryObjects[body].parentJoint]:
                    if joint:
                        moved = kinematics.model.joints[joint]
                        signs[moved.idx_v : moved.idx_v + moved.nv] += sign
        self._sign_rows = list(self._signs)
        self._wrench = np.empty(6)
        self._wrenches = np.empty((count, 6))
        self._row = np.empty(nv)
        # x, y, z, x, y: shifted windows of these buffers give (y, z, x) and (z, x, y) without fancy indexing.
        self._points = np.empty((count, 5))
        self._directions = np.empty((count, 5))
        self._scratch = np.empty((count, 3))
        self._rows = np.empty((count, nv))

    @property
    def count(self) -> int:
        """Number of pairs."""
        return len(self._results)

    def detect(self, treatment: Treatment = "single", beta: float = 100.0) -> Proximity:
        """Return the proximity at the configuration of the last `kinematics.update`.

        Args:
            treatment: see `Treatment`.
            beta: β of the smooth minimum [1/m]; unused for "single".
        """
        if self._nothing is not None:
            return self._nothing
        kinematics = self.kinematics
        pin.updateGeometryPlacements(kinematics.model, kinematics.data, self.geometry, self.data)
        pair = pin.computeDistances(self.geometry, self.data)
        distance = self._results[pair].min_distance
        if treatment == "single":
            row = self.row(pair)
            return Proximity(distance, pair, distance, row, row)
        weights = np.array([result.min_distance for result in self._results])
        np.subtract(distance, weights, out=weights)
        weights *= beta
        np.exp(weights, out=weights)
        total = float(weights.sum())
        weights /= total
        rows = self._all_rows()
        return Proximity(distance, pair, distance - math.log(total) / beta, weights.dot(rows), rows[pair])

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

    def _all_rows(self) -> Array:
        n, p, wrenches, scratch = self._directions, self._points, self._wrenches, self._scratch
        normals = np.concatenate(self._normals).reshape(-1, 3)
        points = np.concatenate([result.getNearestPoint1() for result in self._results]).reshape(-1, 3)
        n[:, :3] = normals
        n[:, 3:] = normals[:, :2]
        p[:, :3] = points
        p[:, 3:] = points[:, :2]
        wrenches[:, :3] = normals
        np.multiply(p[:, 1:4], n[:, 2:5], out=wrenches[:, 3:])
        np.multiply(p[:, 2:5], n[:, 1:4], out=scratch)
        wrenches[:, 3:] -= scratch
        wrenches.dot(self.kinematics.jacobian, self._rows)
        self._rows *= self._signs
        return self._rows
