"""Distance from a singular posture: the smallest singular value of J of the hand's position.

With J (3, n), J Jᵀ u = σ² u for its smallest eigenvalue, and v = Jᵀ u / σ,

    h = σ,      ∂σ/∂q_l = uᵀ (∂J/∂q_l) v,      ∂J_i/∂q_l = z_l × J_i for l ≤ i, z_i × J_l for l > i,

where J_i is column i and z_i the axis of joint i, revolute. σ is differentiable where it is neither 0 nor
equal to the second smallest singular value; at σ = 0 it has a kink, and the row is 0.

Sources: Yoshikawa, Int. J. Robotics Research 4(2), 1985 (manipulability); first-order perturbation theory; as
x_a of Petrič & Žlajpah 2011 ours.
"""

import math
from typing import Final

import numpy as np

from controllers.compiled import Matrix, Vector, loop
from controllers.first_tasks.first_task import FirstTask, Margin
from controllers.kinematics import Arm, Kinematics, fill_point_jacobian

SWEEPS: Final = 6
"""Sweeps of Jacobi's method; after 5 a 3 × 3 matrix has converged in float64."""

NOTHING: Final = 1e-120
"""Off-diagonal entries below this count as 0."""

LEAST: Final = 1e-9
"""σ below which v is taken as 0 [m/rad]."""


@loop("void(float64[:, :], float64[:, :])", fills=("A", "vectors"))
def diagonalise(A: Matrix, vectors: Matrix) -> None:
    """Turn a symmetric A (m, m) into its diagonal of eigenvalues; fill their vectors, the columns (m, m):
    Jacobi.
    """
    m = len(A)
    for i in range(m):
        for k in range(m):
            vectors[i, k] = 1.0 if i == k else 0.0
    for _ in range(SWEEPS):
        for i in range(m - 1):
            for k in range(i + 1, m):
                if abs(A[i, k]) > NOTHING:
                    ratio = (A[k, k] - A[i, i]) / (2.0 * A[i, k])
                    t = (1.0 if ratio >= 0.0 else -1.0) / (abs(ratio) + math.sqrt(ratio * ratio + 1.0))
                    c = 1.0 / math.sqrt(t * t + 1.0)
                    s = t * c
                    for j in range(m):
                        a, b = A[j, i], A[j, k]
                        A[j, i], A[j, k] = c * a - s * b, s * a + c * b
                        a, b = vectors[j, i], vectors[j, k]
                        vectors[j, i], vectors[j, k] = c * a - s * b, s * a + c * b
                    for j in range(m):
                        a, b = A[i, j], A[k, j]
                        A[i, j], A[k, j] = c * a - s * b, s * a + c * b
                    A[i, k] = A[k, i] = 0.0


@loop("float64(float64[:, :], float64[:], float64[:])", fills=("row",))
def smallest_singular_value(jacobian: Matrix, hand: Vector, row: Vector) -> float:
    """σ [m/rad] of J of the hand's position; fills ∂σ/∂q (n,) [m/rad²].

    Args:
        jacobian: the arm's columns (6, n), see `Kinematics`.
        hand: its position (3,), world [m].
    """
    n = len(row)
    J, A, vectors = np.empty((3, n)), np.empty((3, 3)), np.empty((3, 3))
    fill_point_jacobian(jacobian, n, hand, J)
    for i in range(3):
        for k in range(3):
            A[i, k] = 0.0
            for j in range(n):
                A[i, k] += J[i, j] * J[k, j]
    diagonalise(A, vectors)
    least = 0
    for i in range(1, 3):
        if A[i, i] < A[least, least]:
            least = i
    ux, uy, uz = vectors[0, least], vectors[1, least], vectors[2, least]
    # Of Jᵀ u, not of the eigenvalue: that has lost half of the digits.
    square = 0.0
    for j in range(n):
        along = ux * J[0, j] + uy * J[1, j] + uz * J[2, j]
        square += along * along
    sigma = math.sqrt(square)
    row[:] = 0.0
    if sigma < LEAST:
        return sigma
    # uᵀ (z × J_i) = (J_i × u) · z, weighted with v_i.
    for i in range(n):
        v = (ux * J[0, i] + uy * J[1, i] + uz * J[2, i]) / sigma
        zx, zy, zz = jacobian[3, i], jacobian[4, i], jacobian[5, i]
        cx, cy, cz = J[1, i] * uz - J[2, i] * uy, J[2, i] * ux - J[0, i] * uz, J[0, i] * uy - J[1, i] * ux
        # uᵀ (z_i × J_l) = (u × z_i) · J_l.
        dx, dy, dz = uy * zz - uz * zy, uz * zx - ux * zz, ux * zy - uy * zx
        for k in range(i + 1):
            row[k] += v * (cx * jacobian[3, k] + cy * jacobian[4, k] + cz * jacobian[5, k])
        for k in range(i + 1, n):
            row[k] += v * (dx * J[0, k] + dy * J[1, k] + dz * J[2, k])
    return sigma


class SmallestSingularValue(FirstTask):
    """h: smallest singular value σ of J of the hand's position [m/rad]."""

    name = "smallest singular value of J"
    unit = "m/rad"

    def __init__(
        self, kinematics: Kinematics, arm: Arm, critical_value: float = 0.10, nominal_rate: float = 0.3
    ) -> None:
        super().__init__(critical_value, nominal_rate)
        self._jacobian, self._hand = kinematics.jacobian[:, arm.joints], kinematics.hand_pose(arm).translation

    def margin(self) -> Margin:
        row = np.empty(self._jacobian.shape[1])
        return Margin(smallest_singular_value(self._jacobian, self._hand, row), row)
