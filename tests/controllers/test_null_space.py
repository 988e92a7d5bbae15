"""The null space: orthonormal, continuous bases that keep the hand; saturation keeps feasible tasks."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy.optimize import linprog, lsq_linear

from controllers.kinematics import Array, Kinematics, null_space_basis, swing_and_turns
from controllers.limits import TOLERANCE, Authority, VelocityBox, bounded_task, shortened_row
from controllers.null_space_saturation import saturated
from scenes.solo import build_alone
from tests.controllers.helpers import derivative, random_postures
from tests.controllers.test_laws_all import jump_ratio
from tests.controllers.test_limits import STOPS, TOP_SPEED, lwr_box, reach

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
    """A straight arm except for a bend of its elbow [rad]: J of the position loses a rank at 0."""
    q = np.zeros(ROOM.model.nv)
    q[3] = bend
    return q


def test_no_motion_of_a_basis_moves_the_hand_by_finite_differences() -> None:
    for q in random_postures(ROOM, 8, seed=3):
        N = swing_and_turns(jacobian(q))
        assert_allclose(N.T @ N, np.eye(4), atol=1e-12)
        assert_allclose(derivative(hand, q)[:, ARM.joints] @ N, 0.0, atol=1e-8)


def test_the_first_motion_keeps_the_orientation_and_the_others_turn_it() -> None:
    J = jacobian(ROOM.start)
    turns = J[3:] @ swing_and_turns(J)
    assert_allclose(turns[:, 0], 0.0, atol=1e-12)
    for axis in range(3):
        assert turns[axis, axis + 1] > 0.95 * np.linalg.norm(turns[:, axis + 1]) > 0.5


@pytest.mark.parametrize("bend", [0.0, 1e-9, 1e-6, 1e-3])
def test_near_a_singular_posture_the_basis_still_has_four_columns(bend: float) -> None:
    N = null_space_basis(jacobian(stretched(bend), 3))
    assert N.shape == (7, 4)
    assert_allclose(N.T @ N, np.eye(4), atol=1e-12)
    assert_allclose(jacobian(stretched(bend), 3) @ N, 0.0, atol=1e-9)


def test_a_basis_that_starts_at_the_last_one_is_continuous() -> None:
    """Along a curve the change per step halves with the step; without the last basis it does not."""

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


SEEDS = st.integers(0, 100_000)
DIMENSIONS = st.sampled_from([1, 3, 6])


def problem(seed: int, m: int) -> tuple[Array, Array, Array, Array]:
    """J (m, 7), wanted velocities (7,), and bounds around 0, some of them narrow."""
    rng = np.random.default_rng(seed)
    lower, upper = -rng.uniform(0.05, 2.0, 7), rng.uniform(0.05, 2.0, 7)
    return rng.uniform(-0.7, 0.7, (m, 7)), rng.uniform(-2.0, 2.0, 7), lower, upper


def largest_share(J: Array, first: Array, way: Array, lower: Array, upper: Array) -> float:
    """Largest s ≤ 1 such that a q̇ within the bounds has J q̇ = first + s way, by a linear programme."""
    A = np.column_stack([J, -way])
    found = linprog(
        np.append(np.zeros(7), -1.0), A_eq=A, b_eq=first, bounds=[*zip(lower, upper, strict=True), (0.0, 1.0)]
    )
    assert found.status == 0
    return float(found.x[7])


@given(SEEDS, DIMENSIONS)
def test_saturated_keeps_nearly_the_largest_possible_share_of_the_task(seed: int, m: int) -> None:
    """Inside the box, in the task's direction; s = 1 if feasible, else near the linear programme's s."""
    J, wanted, lower, upper = problem(seed, m)
    velocities, share = saturated(J, wanted, lower, upper)
    assert (velocities >= lower).all() and (velocities <= upper).all()
    assert_allclose(J @ velocities, share * (J @ wanted), atol=1e-7)
    most = largest_share(J, np.zeros(m), J @ wanted, lower, upper)
    assert most - 0.15 <= share <= most + 1e-6
    if most > 1.0 - 1e-9:
        assert share == 1.0


@given(SEEDS, DIMENSIONS)
def test_saturated_is_the_nearest_velocity_that_keeps_the_task(seed: int, m: int) -> None:
    """Reference: a general solver with the task as very heavy rows."""
    J, wanted, lower, upper = problem(seed, m)
    velocities, share = saturated(J, wanted, lower, upper)
    heavy = 1e6
    A, b = np.vstack([np.eye(7), heavy * J]), np.append(share * wanted, heavy * share * (J @ wanted))
    fit = lsq_linear(A, b, (lower, upper), method="bvls", tol=1e-14)
    assert_allclose(velocities, fit.x, atol=2e-4)


def test_clipping_and_shortening_lose_a_task_that_the_null_space_keeps() -> None:
    """The null space keeps the hand's velocity to 1e-9; clipping turns it, shortening loses two fifths."""
    rng = np.random.default_rng(3)
    J, wanted = rng.uniform(-0.7, 0.7, (3, 7)), rng.uniform(-1.0, 1.0, 7)
    joint = int(np.abs(wanted).argmax())
    upper = np.full(7, 2.0)
    upper[joint] = 0.6 * abs(wanted[joint])
    box = VelocityBox(-STOPS, STOPS, upper, 10.0)
    task = J @ wanted
    assert_allclose(J @ bounded_task(wanted, J, box, "null_space"), task, atol=1e-9)
    assert np.linalg.norm(J @ bounded_task(wanted, J, box, "distance") - task) > 0.1 * np.linalg.norm(task)
    assert_allclose(J @ bounded_task(wanted, J, box, "scale"), 0.6 * task, atol=1e-12)
    # Without a null space it equals shortening; without an active bound nothing changes.
    assert_array_equal(
        bounded_task(wanted, None, box, "null_space"), bounded_task(wanted, None, box, "scale")
    )
    for treatment in ("distance", "scale", "null_space"):
        assert_array_equal(bounded_task(0.5 * wanted, J, box, treatment), 0.5 * wanted)


@given(SEEDS, DIMENSIONS)
def test_a_kept_row_keeps_its_rate(seed: int, m: int) -> None:
    """From a start inside the box: the row's rate stays, the task approaches its velocity if possible."""
    J, wanted, lower, upper = problem(seed, m)
    rng = np.random.default_rng(seed + 1)
    row, start = rng.uniform(-0.5, 0.5, 7), rng.uniform(lower, upper)
    velocities, share = saturated(J, wanted, lower, upper, start, row)
    assert (velocities >= lower).all() and (velocities <= upper).all()
    assert float(row @ velocities) == pytest.approx(float(row @ start), abs=1e-7)
    way = J @ (wanted - start)
    assert_allclose(J @ velocities, J @ start + share * way, atol=1e-7)
    most = largest_share(
        np.vstack([J, row]), np.append(J @ start, row @ start), np.append(way, 0.0), lower, upper
    )
    assert most - 0.15 <= share <= most + 1e-6


def edge(J: Array, wanted: Array, lower: Array, upper: Array) -> float:
    """Largest size of the task velocity that is kept."""
    first, beyond = 0.0, 3.0
    for _ in range(40):
        middle = 0.5 * (first + beyond)
        first, beyond = (
            (middle, beyond) if saturated(J, middle * wanted, lower, upper)[1] == 1.0 else (first, middle)
        )
    return first


def test_saturated_is_continuous_on_both_sides_of_the_edge() -> None:
    """From no task to far beyond reach: half the grid, half the step, while the task is kept and after."""
    J, wanted, lower, upper = problem(9, 3)
    last = edge(J, wanted, lower, upper)
    assert 0.1 < last < 1.0
    velocities = lambda size: saturated(J, size * wanted, lower, upper)[0]  # noqa: E731
    assert 0.4 < jump_ratio(velocities, 0.0, last - 1e-9, 300) < 0.6
    assert 0.4 < jump_ratio(velocities, last + 1e-6, 3.0, 300) < 0.6
    # At the edge the share falls by some hundredths, as documented.
    assert 0.85 < saturated(J, (last + 1e-6) * wanted, lower, upper)[1] <= 1.0


def test_special_tasks() -> None:
    # A fixed joint, J with two equal rows, and a zero task all have a solution within the bounds.
    J, wanted, lower, upper = problem(2, 3)
    upper[1] = lower[1] = 0.0
    velocities, share = saturated(J, wanted, lower, upper)
    assert velocities[1] == 0.0 and share > 0.0
    for awkward in (np.vstack([J, J[:1]]), np.zeros((3, 7)), np.vstack([J, np.eye(7)])):
        velocities, share = saturated(awkward, wanted, lower, upper)
        assert np.isfinite(velocities).all() and (velocities >= lower).all() and (velocities <= upper).all()
        assert_allclose(awkward @ velocities, share * (awkward @ wanted), atol=1e-6)


@given(SEEDS)
def test_shortening_keeps_the_direction_and_reports_the_lost_rate(seed: int) -> None:
    """s q̇ with the largest s in the box; if it loses distance rate, the limiting joint is named."""
    rng = np.random.default_rng(seed)
    box = lwr_box(rng.uniform(-1.0, 1.0, 7) * STOPS)
    wanted, row = rng.uniform(-3.0, 3.0, 7) * TOP_SPEED, rng.uniform(-0.5, 0.5, 7)
    bounded = shortened_row(wanted, row, box)
    assert box.contains(bounded.velocities)
    share, joint = box.largest_share(wanted)
    assert_allclose(bounded.velocities, share * wanted, atol=1e-12)
    assert not box.contains(wanted * min(share + 1e-6, 1.0)) or share == 1.0
    lost = (1.0 - share) * abs(float(row @ wanted))
    assert (bounded.authority is Authority.FULL) == (lost <= TOLERANCE)
    if bounded.authority is not Authority.FULL:
        assert bounded.joint == joint
        # The bounded row can reach any rate within its reach; shortening loses part of it.
        assert abs(float(row @ bounded.velocities)) <= max(abs(r) for r in reach(row, box)) + 1e-9
