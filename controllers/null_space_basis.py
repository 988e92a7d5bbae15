"""A basis of a task's null space that goes along with the posture, so that each of its motions stays the same motion."""

import numpy as np

from controllers.kinematics import Array


def null_space_basis(J: Array, before: Array | None = None) -> Array:
    """Return orthonormal columns (n, n − m) that span the null space of J, also next to a singular posture.

    At a singular posture the null space is larger; it is then cut down to the n − m directions that the task feels least.

    Args:
        J: of the task (m, n), m < n.
        before: the basis of a posture nearby (n, n − m); the result is the basis nearest to it. None for any basis.
    """
    free = np.linalg.svd(J)[2][len(J) :].T
    if before is None:
        return free
    # Orthogonal Procrustes problem: of all bases of this null space, the one with the least sum of squared differences.
    left, _, right = np.linalg.svd(free.T.dot(before))
    return free.dot(left).dot(right)


def swing_and_turns(J: Array) -> Array:
    """Return a basis (7, 4) of the null space of a hand's position: a motion that does not turn the hand, then three that turn it.

    The turns are about the world's axes, as nearly as orthonormal columns can be.

    Args:
        J: of the hand's position and orientation (6, 7).
    """
    swing = null_space_basis(J)
    turns = null_space_basis(np.vstack([J[:3], swing.T]))
    left, _, right = np.linalg.svd(J[3:].dot(turns))
    return np.column_stack([swing, turns.dot(right.T).dot(left.T)])
