"""The part of an avoiding motion that does not move the hand."""

from typing import Final

from scipy.linalg.lapack import dposv

from controllers.kinematics import Array

ROUNDING: Final = 1e-12
"""Added to the diagonal of J Jᵀ (order 1), so that a singular J has a Cholesky factor."""


def free_part(row: Array, task_jacobian: Array) -> Array:
    """J_d N (n,) with N = I − J^# J, eq. (6), for J_d (n,) and J (m, n); J (J_d N)ᵀ = 0 to rounding, also for
    a singular J.
    """
    # The second pass removes what ROUNDING and the condition of J Jᵀ left over from the first.
    return mostly_free_part(mostly_free_part(row, task_jacobian, 0.0), task_jacobian, 0.0)


def mostly_free_part(row: Array, task_jacobian: Array, damping_square: float) -> Array:
    """μ² (JᵀJ + μ² I)⁻¹ J_dᵀ (n,) for μ² = `damping_square`, J_d (n,) and J (m, n).

    Scaled to J_d Δ = c it is the Δ with the least |J Δ|² + μ² |Δ|². μ → 0 gives J_d N.
    """
    gram = task_jacobian.dot(task_jacobian.T)
    gram.ravel()[:: len(gram) + 1] += damping_square + ROUNDING
    return row - dposv(gram, task_jacobian.dot(row))[1].dot(task_jacobian)
