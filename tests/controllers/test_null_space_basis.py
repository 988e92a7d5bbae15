"""The bases of the null space: orthonormal, felt by no hand, continuous along a way, next to singular postures too."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from controllers.kinematics import Array, Kinematics
from controllers.null_space_basis import null_space_basis, swing_and_turns
from scenes.room import build_alone
from tests.controllers.helpers import derivative, random_postures

ROOM = build_alone()
ARM = ROOM.arms[0]
KINEMATICS = Kinematics(ROOM.model, ROOM.arms)


def jacobian(q: Array, dimension: int = 6) -> Array:
    KINEMATICS.update(q)
    return KINEMATICS.hand_jacobian(ARM, dimension).copy()


def hand(q: Array) -> Array:
    KINEMATICS.update(q)
    return KINEMATICS.hand_pose(ARM).translation.copy()


def stretched(bend: float) -> Array:
    """An arm that is straight but for a bend of its elbow [rad]: J of the position loses a rank at 0."""
    q = np.zeros(ROOM.model.nv)
    q[3] = bend
    return q


def test_no_motion_of_a_basis_moves_the_hand_by_finite_differences() -> None:
    for q in random_postures(ROOM, 8, seed=3):
        N = swing_and_turns(jacobian(q))
        assert_allclose(N.T @ N, np.eye(4), atol=1e-12)
        assert_allclose(derivative(hand, q)[:, ARM.joints] @ N, 0.0, atol=1e-8)


def test_the_first_motion_does_not_turn_the_hand_and_the_others_turn_it_about_the_axes() -> None:
    J = jacobian(ROOM.start)
    turns = J[3:] @ swing_and_turns(J)
    assert_allclose(turns[:, 0], 0.0, atol=1e-12)
    for axis in range(3):
        assert turns[axis, axis + 1] > 0.95 * np.linalg.norm(turns[:, axis + 1]) > 0.5


@pytest.mark.parametrize("bend", [0.0, 1e-9, 1e-6, 1e-3])
def test_next_to_a_singular_posture_there_are_still_four(bend: float) -> None:
    N = null_space_basis(jacobian(stretched(bend), 3))
    assert N.shape == (7, 4)
    assert_allclose(N.T @ N, np.eye(4), atol=1e-12)
    assert_allclose(jacobian(stretched(bend), 3) @ N, 0.0, atol=1e-9)


def test_a_basis_goes_along_with_the_posture_where_one_of_its_own_jumps() -> None:
    """Along a curve the change from step to step halves with the step; without the basis before it does not."""

    def largest_change(steps: int, along: bool) -> float:
        q0, q1 = random_postures(ROOM, 2, seed=5)
        basis, worst = null_space_basis(jacobian(q0, 3)), 0.0
        for share in np.linspace(0.0, 1.0, steps + 1)[1:]:
            after = null_space_basis(jacobian(q0 + share * (q1 - q0), 3), basis if along else None)
            worst, basis = max(worst, float(np.abs(after - basis).max())), after
        return worst

    coarse, fine = (largest_change(steps, True) for steps in (400, 800))
    assert fine < 0.6 * coarse < 0.1
    assert largest_change(800, False) > 0.5
