"""A distance between capsules that is smooth also where their axes are parallel.

The distance of two capsules has a kink where their axes are parallel: the closest points jump from one end to the other. The cure
is to make the problem that finds them strictly convex. With half axes a, b, centres c_a, c_b and r = c_a − c_b,

    F = min over s, t in [−1, 1] of |r + s a − t b|² + (ε/4) (s² + t²),      D = √F,      d = D − √(ε/2) − (r_a + r_b).

The minimiser is unique and Lipschitz continuous in q, so that D is continuously differentiable with a Lipschitz gradient wherever
F > 0, and its gradient is that of the fixed s, t (envelope theorem). As F ≤ |r + s a − t b|² + ε/2 at the true closest points, d is
never larger than the true distance. A relative: strictly convex bounding volumes (Escande et al., IEEE T-RO 30(3), 2014).

The term with ε is that of two more dimensions: with â = (a, √ε/2, 0) / |(a, √ε/2)|, b̂ alike with the last two exchanged, and r̂ = (r, 0, 0),
it is F = |r̂ + s â − t b̂|² over s and t that are now lengths, and ½ ∂F/∂s = s + â·r̂ − â·b̂ t, ½ ∂F/∂t = t − b̂·r̂ − â·b̂ s.
"""

from typing import Final

import coal
import numpy as np
import pinocchio as pin
from numpy.lib.stride_tricks import as_strided

from controllers.kinematics import Array

TINY: Final = 1e-12
"""Least F [m²]: where two axes cross in their middle, the gradient is 0 instead of 0/0."""

ONES: Final = np.ones(5)
THREE: Final = np.ones(3)
"""Their products with an array are its sums, sooner than by `sum`."""


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
        count = len(pairs)
        half = np.array([body.geometry.halfLength if isinstance(body.geometry, coal.Capsule) else 0.0 for body in bodies])
        radii = np.array([body.geometry.radius for body in bodies])
        self._first, self._second = [pair.first for pair in pairs], [pair.second for pair in pairs]
        self._halves = half[self._first], half[self._second]
        self._reach = radii[self._first] + radii[self._second]
        self._data, self._columns = data, _placement_columns(data)
        # Every view is made once: making one takes as long as adding two small arrays.
        # Columns, one a pair in each group: â, b̂, r̂, â, c_a, c_b.
        self._vectors = vectors = np.zeros((5, 6 * count))
        self._moving, self._axes, self._centres = vectors[:3], vectors[:, : 2 * count], vectors[:, 4 * count :]
        self._factors = vectors[:3, : 3 * count], vectors[:3, count : 4 * count]
        self._products, self._dots = np.empty((3, 3 * count)), np.empty(3 * count)
        self._ab, self._br, self._ra = self._dots.reshape(3, count)
        self._parameters, self._work = np.empty(2 * count), np.empty(count)
        self._s, self._t = self._parameters.reshape(2, count)
        self._along, self._points = np.empty((5, 2 * count)), np.empty((5, 2 * count))
        self._ends = self._points[:, :count], self._points[:, count:]
        self._gaps, self._squares = np.empty((5, count)), np.empty((5, count))
        self.points, self.gaps, self.lengths = self._points[:3, :count], self._gaps[:3], np.empty(count)
        # Against an array of its size an array is compared in half the time that a number takes.
        self._one, self._tiny = np.ones(count), np.full(count, TINY)
        self._set(1e-4)

    def update(self, epsilon: float) -> Array:
        """Return d (pairs,) at the present placements, a fresh array [m].

        Args:
            epsilon: ε [m²], positive; d is at most √(ε/2) below the true distance.
        """
        if epsilon != self._epsilon:
            self._set(epsilon)
        add, subtract, multiply, minimum, maximum = np.add, np.subtract, np.multiply, np.minimum, np.maximum
        self._columns.dot(self._selection, self._moving)
        THREE.dot(multiply(*self._factors, self._products), self._dots)
        ab, br, ra, s, t, work = self._ab, self._br, self._ra, self._s, self._t, self._work
        (s_most, t_most), (s_least, t_least) = self._most, self._least
        # The unconstrained s, the best t for it, the best s for that: exact for a strictly convex function of two variables.
        subtract(multiply(ab, br, s), ra, s)
        np.divide(s, subtract(self._one, multiply(ab, ab, work), work), s)
        minimum(maximum(s, s_least, out=s), s_most, out=s)
        add(multiply(ab, s, t), br, t)
        minimum(maximum(t, t_least, out=t), t_most, out=t)
        subtract(multiply(ab, t, s), ra, s)
        minimum(maximum(s, s_least, out=s), s_most, out=s)
        add(self._centres, multiply(self._axes, self._parameters, self._along), self._points)
        first, second = self._ends
        gaps = subtract(second, first, self._gaps)
        F = ONES.dot(multiply(gaps, gaps, self._squares), work)
        return subtract(np.sqrt(maximum(F, self._tiny, out=F), self.lengths), self._inside)

    def _set(self, epsilon: float) -> None:
        self._epsilon, self._inside = epsilon, self._reach + (epsilon / 2.0) ** 0.5
        most = np.sqrt(np.square(self._halves) + epsilon / 4.0)
        self._most, self._least = tuple(most), tuple(-most)
        a, b = self._halves / most
        count = len(a)
        each, vectors = np.arange(count), self._vectors.reshape(5, 6, count)
        vectors[3, 0], vectors[4, 1] = (epsilon / 4.0) ** 0.5 / most
        # From the columns of the placements to the vectors.
        self._selection = np.zeros((self._columns.shape[1], 6 * count))
        z, origin, selection = 2, 3, self._selection.reshape(-1, 4, 6, count)
        selection[self._first, z, 0, each] = selection[self._first, z, 3, each] = a
        selection[self._second, z, 1, each] = b
        selection[self._first, origin, 2, each] = selection[self._first, origin, 4, each] = 1.0
        selection[self._second, origin, 2, each] = -1.0
        selection[self._second, origin, 5, each] = 1.0


def _placement_columns(data: pin.GeometryData) -> Array:
    """Return the x, y and z axis and the origin of every placement as columns (3, 4 bodies), a live view of Pinocchio's memory.

    Raises:
        RuntimeError: Pinocchio does not keep the placements one after the other.
    """
    rotations, origins = [placement.rotation for placement in data.oMg], [placement.translation for placement in data.oMg]
    begin = _address(rotations[0])
    for i, (rotation, origin) in enumerate(zip(rotations, origins, strict=True)):
        if (_address(rotation), _address(origin)) != (begin + 96 * i, begin + 96 * i + 72):
            raise RuntimeError("this version of Pinocchio keeps placements in another way; install that of requirements.lock")
    return as_strided(rotations[0], (3, 4 * len(rotations)), (8, 24), writeable=False)


def _address(array: Array) -> int:
    return int(array.__array_interface__["data"][0])
