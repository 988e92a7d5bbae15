"""A distance between capsules that is smooth also where their axes are parallel.

The distance of two capsules has a kink where their axes are parallel: the closest points jump from one end to the other. The cure
is to make the problem that finds them strictly convex. With half axes a, b, centres c_a, c_b and r = c_a − c_b,

    F = min over s, t in [−1, 1] of |r + s a − t b|² + (ε/4) (s² + t²),      D = √F,      d = D − √(ε/2) − (r_a + r_b).

The minimiser is unique and Lipschitz continuous in q, so that D is continuously differentiable with a Lipschitz gradient wherever
F > 0, and its gradient is that of the fixed s, t (envelope theorem). As F ≤ |r + s a − t b|² + ε/2 at the true closest points, d is
never larger than the true distance. A relative: strictly convex bounding volumes (Escande et al., IEEE T-RO 30(3), 2014).
"""

from typing import Final

import coal
import numpy as np
import pinocchio as pin

from controllers.kinematics import Array

TINY: Final = 1e-12
"""Least F [m²]: where two axes cross in their middle, the gradient is 0 instead of 0/0."""

ONES: Final = np.ones(3)


class ConvexDistances:
    """The strictly convex distance of every pair of a geometry; computes without allocating more than a few small arrays.

    Args:
        geometry: capsules and spheres, with at least one pair.
        data: of the geometry; its placements must be up to date at `update`.

    Attributes:
        points: on the axis of each pair's first body (3, pairs), world [m]; of the last `update`, as all below.
        gaps: from there to the point on the second body's axis (3, pairs) [m].
        lengths: D (pairs,) [m]; the gradient of the distance is that of the gap along gap / D, which is shorter than a unit vector.
    """

    def __init__(self, geometry: pin.GeometryModel, data: pin.GeometryData) -> None:
        bodies, pairs = geometry.geometryObjects, geometry.collisionPairs
        count, origin = len(pairs), len(bodies)
        half = np.array([body.geometry.halfLength if isinstance(body.geometry, coal.Capsule) else 0.0 for body in bodies])
        radii = np.array([body.geometry.radius for body in bodies])
        first, second, each = [pair.first for pair in pairs], [pair.second for pair in pairs], np.arange(count)
        # The placements' z axes, then their origins: one product with constants gives a, b, r, a again, and c_a of every pair.
        self._axes_and_origins = [placement.rotation[:, 2] for placement in data.oMg] + [p.translation for p in data.oMg]
        selection = np.zeros((2 * origin, 5, count))
        selection[first, 0, each] = selection[first, 3, each] = half[first]
        selection[second, 1, each] = half[second]
        selection[np.add(first, origin), 2, each] = selection[np.add(first, origin), 4, each] = 1.0
        selection[np.add(second, origin), 2, each] = -1.0
        self._selection = selection.reshape(2 * origin, 5 * count)
        self._squares = half[first] ** 2, half[second] ** 2
        self._reach = radii[first] + radii[second]
        # Against an array of its size an array is compared in half the time that a number takes.
        self._one, self._minus_one, self._tiny = np.ones(count), -np.ones(count), np.full(count, TINY)
        self._set(1e-4)
        self._vectors = np.empty((3, 5 * count))
        a, b, r, _, c = (self._vectors[:, k * count : (k + 1) * count] for k in range(5))
        self._parts = a, b, r, c
        self._factors = self._vectors[:, : 3 * count], self._vectors[:, count : 4 * count]
        self.points = np.empty((3, count))
        self.gaps = np.empty((3, count))
        self.lengths = np.empty(count)

    def update(self, epsilon: float) -> Array:
        """Return d (pairs,) at the present placements, a fresh array [m].

        Args:
            epsilon: ε [m²], positive; d is at most √(ε/2) below the true distance.
        """
        if epsilon != self._epsilon:
            self._set(epsilon)
        aa, bb, aabb = self._diagonal
        np.concatenate(self._axes_and_origins).reshape(-1, 3).T.dot(self._selection, self._vectors)
        a, b, r, c = self._parts
        ab, br, ra = ONES.dot(self._factors[0] * self._factors[1]).reshape(3, -1)
        # The unconstrained s, the best t for it, the best s for that: exact for a strictly convex function of two variables.
        s = self._clipped((ab * br - bb * ra) / (aabb - ab * ab))
        t = self._clipped((ab * s + br) / bb)
        s = self._clipped((ab * t - ra) / aa)
        along = a * s
        np.add(c, along, out=self.points)
        np.subtract(b * t, along, out=self.gaps)
        self.gaps -= r
        F = ONES.dot(self.gaps * self.gaps)
        F += (s * s + t * t) * self._quarter
        np.sqrt(np.maximum(F, self._tiny, out=F), out=self.lengths)
        return self.lengths - self._inside

    def _set(self, epsilon: float) -> None:
        aa, bb = (squares + epsilon / 4.0 for squares in self._squares)
        self._quarter = np.full(len(aa), epsilon / 4.0)
        self._epsilon, self._diagonal, self._inside = epsilon, (aa, bb, aa * bb), self._reach + (epsilon / 2.0) ** 0.5

    def _clipped(self, values: Array) -> Array:
        np.minimum(values, self._one, out=values)
        return np.maximum(values, self._minus_one, out=values)
