"""Section III: M against finite differences of the closed loop, its closed forms, the extreme cases, and the barrier function W."""

import math
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy.integrate import quad

from controllers.activation import activation_slope
from controllers.errors import BadSetting
from controllers.kinematics import Array, damped_solution, pseudo_inverse
from controllers.laws.situation import AUTHORITY, Situation, textbook_projector
from controllers.laws.smooth_priority import SmoothPriority
from controllers.proximity import Proximity
from controllers.stability import TOLERANCE, Analysis, analyse, barrier, barrier_integral
from controllers.tasks import pose_error
from tests.controllers.helpers import bodies, derivative, random_postures

SEEDS = st.integers(0, 10_000)
SHARES = st.floats(0.0, 1.0)
GAINS = st.floats(0.1, 20.0)
DIMENSIONS = st.sampled_from([1, 2, 3, 6])
LAW = SmoothPriority(0.15, 6.0, 0.3)


def tasks(seed: int, m: int, n: int = 7) -> tuple[Array, Array]:
    """A random J_d (n,) and J_b (m, n)."""
    random = np.random.default_rng(seed)
    return random.normal(size=n) * 0.4, random.normal(size=(m, n)) * 0.4


def sym(matrix: Array) -> Array:
    """Symmetric part."""
    return np.asarray(0.5 * (matrix + matrix.T), np.float64)


def in_metric(analysis: Analysis, row: Array, J_b: Array) -> Array:
    """M with e_a in units of |J_d| and e_b in the metric e_bᵀ (J_b J_bᵀ)⁻¹ e_b."""
    scale = np.zeros_like(analysis.M)
    scale[0, 0] = np.linalg.norm(row)
    scale[1:, 1:] = np.linalg.cholesky(J_b @ J_b.T)
    return np.asarray(np.linalg.solve(scale, analysis.M @ scale), np.float64)


# ---- M against the closed loop ------------------------------------------------------------------------------------------------


class LeftArm:
    """The LWR's left arm, the right one frozen beside it: two smooth functions of q, and the law that moves it."""

    def __init__(self, q: Array) -> None:
        self.room, self.kinematics, self.detector = bodies("torso")
        self.arm = self.room.arms[0]
        self.q = q
        near = self.look(q[self.arm.joints])
        self.pair = near.pair

    def look(self, q_left: Array) -> Proximity:
        """Put the left arm somewhere and detect."""
        q = self.q.copy()
        q[self.arm.joints] = q_left
        self.kinematics.update(q)
        return self.detector.detect()

    def distance(self, q_left: Array) -> float:
        """d of the pair that was closest at first."""
        self.look(q_left)
        return float(self.detector.distances()[self.pair])

    def hand(self, q_left: Array) -> pin.SE3:
        """Pose of the hand, a copy."""
        self.look(q_left)
        return self.kinematics.hand_pose(self.arm).copy()


def near_postures(count: int, seed: int, shortest: float) -> list[LeftArm]:
    """Postures with d between 0.02 and 0.6 m and |J_d| above `shortest`."""
    room, kinematics, detector = bodies("torso")
    found: list[LeftArm] = []
    for q in random_postures(room, 5000, seed):
        kinematics.update(q)
        near = detector.detect()
        if 0.02 < near.distance < 0.6 and np.linalg.norm(near.row[room.arms[0].joints]) > shortest:
            found.append(LeftArm(q))
            if len(found) == count:
                break
    assert len(found) == count
    return found


def test_m_gives_the_error_rate_of_the_closed_loop() -> None:
    """−de/dt = M e by central differences of d(q) and the hand's place along the law's q̇, and V̇ = −eᵀ M e with them.

    Exact setting: both targets held; e_a = λ v / K_a with the λ of the moment, so that the target of x_a = d is d + e_a.
    """
    random, K_a, K_b, h = np.random.default_rng(3), 5.0, 2.0, 1e-5
    rising = 0
    for left in near_postures(40, 3, AUTHORITY):
        q = left.q[left.arm.joints]
        near = left.look(q)
        row, J_b = near.row[left.arm.joints], left.kinematics.hand_jacobian(left.arm)[:3]
        e_b = random.normal(size=3) * 0.1
        goal_b = left.hand(q).translation + e_b
        analysis = analyse(row, J_b, LAW.activation(near.distance), K_a, K_b)
        e = analysis.error(LAW.nominal_velocity, e_b)
        assert e[0] == pytest.approx(LAW.activation(near.distance) * 0.3 / 5.0)
        goal_a = near.distance + e[0]
        dq = LAW(Situation(q, pseudo_inverse(J_b) @ (K_b * e_b), row, near.distance, 0.0))

        def errors(t: float, left: LeftArm = left, q: Array = q, dq: Array = dq, a: float = goal_a, b: Array = goal_b) -> Array:
            moved = q + t * dq
            return np.array([a - left.distance(moved), *(b - left.hand(moved).translation)])

        assert_allclose(errors(0.0), e, atol=1e-12)
        forth, back = errors(h), errors(-h)
        scale = max(1.0, float(np.linalg.norm(dq)))
        assert_allclose((back - forth) / (2.0 * h), analysis.M @ e, atol=1e-6 * scale)
        assert 0.5 * (forth @ forth - back @ back) / (2.0 * h) == pytest.approx(analysis.lyapunov_rate(e), abs=1e-6 * scale)
        lengths = np.linalg.norm(forth[1:]), np.linalg.norm(back[1:])
        assert (lengths[0] - lengths[1]) / (2.0 * h) == pytest.approx(analysis.task_error_rate(e), abs=1e-6 * scale)
        assert analysis.lyapunov(e) == pytest.approx(0.5 * (e @ e))
        rising += analysis.lyapunov_rate(e) > 0.0
    # Positive control: among these are moments at which V does rise.
    assert rising > 0


def test_with_the_laws_own_gain_the_avoidance_error_moves_as_m_says() -> None:
    """K_a = −v dλ/dd: no target has to be held, e_a = λ(d) v / K_a itself moves by −(M e)_a; with twice that K_a it does not."""
    random, h = np.random.default_rng(4), 1e-5
    apart = 0
    for left in near_postures(40, 4, AUTHORITY):
        q = left.q[left.arm.joints]
        near = left.look(q)
        slope = -0.3 * activation_slope(near.distance, 0.15, 6.0)
        if not 0.16 < near.distance < 0.35:
            continue
        row, J_b = near.row[left.arm.joints], left.kinematics.hand_jacobian(left.arm)[:3]
        e_b = random.normal(size=3) * 0.1
        dq = LAW(Situation(q, pseudo_inverse(J_b) @ (2.0 * e_b), row, near.distance, 0.0))
        lam = LAW.activation(near.distance)
        lams = [LAW.activation(left.distance(q + t * dq)) for t in (h, -h)]
        for factor in (1.0, 2.0):
            analysis = analyse(row, J_b, lam, factor * slope, 2.0)
            e = analysis.error(0.3, e_b)
            rate = (lams[0] - lams[1]) * 0.3 / (factor * slope) / (2.0 * h)
            says = -float(analysis.M[0] @ e)
            if factor == 1.0:
                assert rate == pytest.approx(says, abs=2e-5 * max(1.0, float(np.linalg.norm(dq))))
            else:
                apart += abs(rate - says) > 1e-3
    assert apart > 5


@pytest.mark.parametrize("task", ["position", "pose"])
def test_the_damped_m_is_that_of_the_running_loop(task: str) -> None:
    """With the damped inverses M e is J q̇ of task and law as they run, singular rows included; without, it is not."""
    random, m = np.random.default_rng(5), 3 if task == "position" else 6
    apart = 0.0
    for left in near_postures(40, 5, 0.0):
        q = left.q[left.arm.joints]
        pose = left.hand(q)
        near = left.look(q)
        row, J_b = near.row[left.arm.joints], left.kinematics.hand_jacobian(left.arm)[:m]
        goal = pin.SE3(pin.exp3(random.normal(size=3) * 0.2) @ pose.rotation, pose.translation + random.normal(size=3) * 0.1)
        e_b = pose_error(pose, goal.translation, goal.rotation)
        nominal = damped_solution(J_b, 2.0 * e_b[:m])
        dq = LAW(Situation(q, nominal, row, near.distance, 0.0))
        damped, exact = (analyse(row, J_b, LAW.activation(near.distance), 2.0, 2.0, damped) for damped in (True, False))
        e = damped.error(0.3, e_b[:m])
        assert_allclose(damped.M @ e, np.concatenate(((row @ dq,), J_b @ dq)), atol=1e-10)
        apart = max(apart, float(np.abs((exact.M - damped.M) @ e).max()))
        # The logarithm's rate is not the hand's rate of turn, but along the error it is: V̇ and |e_b| are exact for a pose too.
        step = 1e-5
        there, back = (left.hand(q + t * dq) for t in (step, -step))
        lengths = [float(np.linalg.norm(pose_error(p, goal.translation, goal.rotation)[:m])) for p in (there, back)]
        assert (lengths[0] - lengths[1]) / (2.0 * step) == pytest.approx(damped.task_error_rate(e), abs=1e-5)
        lengths = [float(np.linalg.norm(pose_error(p, goal.translation, goal.rotation)[:3])) for p in (there, back)]
        assert (lengths[0] - lengths[1]) / (2.0 * step) == pytest.approx(damped.task_error_rate(e, slice(3)), abs=1e-5)
    assert apart > 1e-3


@given(SEEDS, DIMENSIONS, SHARES, GAINS, GAINS)
def test_m_is_eq_25(seed: int, m: int, lam: float, K_a: float, K_b: float) -> None:
    """The blocks as eqs (12) and (21) give them with numpy's pseudo-inverses and N' as a matrix."""
    row, J_b = tasks(seed, m)
    J_a, J_b_sharp = row[None, :], np.linalg.pinv(J_b)
    J_a_sharp, N_a = np.linalg.pinv(J_a), textbook_projector(row, lam)
    a = analyse(row, J_b, lam, K_a, K_b)
    assert_allclose(a.M_aa, J_a @ J_a_sharp * K_a, atol=1e-9)
    assert_allclose(a.M_ab, J_a @ N_a @ J_b_sharp * K_b, atol=1e-8)
    assert_allclose(a.M_ab, (1.0 - lam) * J_a @ J_b_sharp * K_b, atol=1e-8)
    assert_allclose(a.M_ba, J_b @ J_a_sharp * K_a, atol=1e-8)
    assert_allclose(a.M_bb, J_b @ N_a @ J_b_sharp * K_b, atol=1e-8)
    assert a.coupling == pytest.approx(float(np.linalg.norm(J_a @ J_b_sharp, 2)), rel=1e-8)
    assert a.smallest_eigenvalue == pytest.approx(float(np.linalg.eigvalsh(sym(a.M))[0]), abs=1e-9)


@given(SEEDS, SHARES, GAINS, GAINS)
def test_a_posture_task_is_a_task_with_the_identity(seed: int, lam: float, K_a: float, K_b: float) -> None:
    """None means J_b = I, entry by entry; such tasks are always dependent: rank 7 < 1 + 7, ρ = 1, ‖J_a J_b^#‖ = |J_d|."""
    row, _ = tasks(seed, 1)
    short, long = analyse(row, None, lam, K_a, K_b), analyse(row, np.eye(7), lam, K_a, K_b)
    assert_allclose(short.M, long.M, atol=1e-12)
    for name in ("smallest_eigenvalue", "slowest_mode", "coupling", "angle", "rho", "survival"):
        assert getattr(short, name) == pytest.approx(getattr(long, name), abs=1e-7), name
    for a in (short, long):
        assert (a.rank_a, a.rank_b, a.rank_stack) == (1, 7, 7)
        assert not (a.independent or a.orthogonal)
        assert a.survival == pytest.approx(1.0 - lam) and a.slowest_mode == pytest.approx(0.0, abs=1e-12)
        assert a.coupling == pytest.approx(float(np.linalg.norm(row)))
    assert short.joint_task and not long.joint_task


# ---- what follows from M ------------------------------------------------------------------------------------------------------


@given(SEEDS, DIMENSIONS, SHARES, GAINS, GAINS)
def test_the_surviving_share_is_an_eigenvalue(seed: int, m: int, lam: float, K_a: float, K_b: float) -> None:
    """In the metric e_bᵀ (J_b J_bᵀ)⁻¹ e_b, M_bb/K_b is symmetric with eigenvalues 1 − λ ρ² once, and 1."""
    row, J_b = tasks(seed, m)
    a = analyse(row, J_b, lam, K_a, K_b)
    block = in_metric(a, row, J_b)[1:, 1:] / K_b
    assert_allclose(block, block.T, atol=1e-7)
    assert_allclose(np.linalg.eigvalsh(sym(block)), [a.survival] + [1.0] * (m - 1), atol=1e-7)
    basis = np.linalg.svd(J_b, full_matrices=False)[2]
    assert a.rho == pytest.approx(float(np.linalg.norm(basis @ row) / np.linalg.norm(row)), abs=1e-9)
    assert a.survival == pytest.approx(1.0 - lam * a.rho**2, abs=1e-12)
    assert math.cos(a.angle) == pytest.approx(a.rho, abs=1e-9)


@given(SEEDS, DIMENSIONS, SHARES, GAINS, GAINS)
def test_the_slowest_mode_is_the_smallest_eigenvalue_of_m(seed: int, m: int, lam: float, K_a: float, K_b: float) -> None:
    """All eigenvalues of M are real and positive while the tasks are independent, whatever λ: the frozen loop is stable."""
    row, J_b = tasks(seed, m)
    a = analyse(row, J_b, lam, K_a, K_b)
    assert a.independent
    values = np.linalg.eigvals(a.M)
    # Nearly equal eigenvalues of a matrix that is not symmetric are only good to the root of the machine's precision.
    assert_allclose(values.imag, 0.0, atol=1e-4)
    assert values.real.min() == pytest.approx(a.slowest_mode, abs=1e-4, rel=1e-4)
    assert a.slowest_mode > 0.0
    assert a.smallest_eigenvalue <= a.slowest_mode + 1e-6


@given(SEEDS, DIMENSIONS, st.floats(0.01, 1.0), GAINS)
def test_when_the_condition_holds_in_the_natural_metric(seed: int, m: int, lam: float, K: float) -> None:
    """With K_a = K_b and in the metric of the two tasks, sym(M) > 0 if and only if ρ² (1 + λ²/4) < 1."""
    row, J_b = tasks(seed, m)
    a = analyse(row, J_b, lam, K, K)
    margin = 1.0 - a.rho**2 * (1.0 + 0.25 * lam**2)
    least = float(np.linalg.eigvalsh(sym(in_metric(a, row, J_b)))[0])
    if abs(margin) > 1e-6:
        assert (least > 0.0) == (margin > 0.0)


@given(SEEDS, DIMENSIONS, SHARES, GAINS, GAINS)
def test_the_flag_is_v_falling_for_every_error(seed: int, m: int, lam: float, K_a: float, K_b: float) -> None:
    """While the flag is up no error lets V rise; while it is down the eigenvector of sym(M) does not let V fall."""
    row, J_b = tasks(seed, m)
    a = analyse(row, J_b, lam, K_a, K_b)
    if a.condition_holds:
        for e in np.random.default_rng(seed).normal(size=(20, m + 1)) * ([1.0] * (m + 1) if lam else [0.0] + [1.0] * m):
            assert a.lyapunov_rate(e) < 0.0
    else:
        e = np.linalg.eigh(sym(a.M))[1][:, 0]
        assert a.lyapunov_rate(e) > -1e-6


def test_neither_answer_is_rare() -> None:
    """Positive control of the test above: both answers occur among such tasks, for independent tasks too."""
    answers = [analyse(*tasks(seed, 3), 0.7, 2.0, 2.0) for seed in range(200)]
    assert all(a.independent for a in answers)
    assert 10 < sum(a.condition_holds for a in answers) < 190


def test_stable_without_the_condition() -> None:
    """Sufficient, not necessary: sym(M) has a negative eigenvalue, V rises for a while, and e dies out all the same."""
    row, J_b = np.array([0.6, 0.2, 0.0]), np.array([[0.9, 0.0, 0.0], [0.0, 0.0, 0.4]])
    a = analyse(row, J_b, 0.9, 1.0, 1.0)
    assert a.independent and not a.orthogonal and not a.condition_holds
    assert a.smallest_eigenvalue < -0.1 and a.slowest_mode > 0.05
    e = np.linalg.eigh(sym(a.M))[1][:, 0]
    values = [a.lyapunov(e)]
    for _ in range(20_000):
        e = e - 0.01 * a.M @ e
        values.append(a.lyapunov(e))
    assert max(values) > 1.001 * values[0] and values[-1] < 1e-6 * values[0]


# ---- extreme cases ------------------------------------------------------------------------------------------------------------


@given(SEEDS, st.sampled_from([1, 3, 6]), SHARES, GAINS, GAINS)
def test_orthogonal_tasks_have_what_the_paper_proves(seed: int, m: int, lam: float, K_a: float, K_b: float) -> None:
    """J_a J_b^# = 0, eq. (16): M = diag(K_a, K_b), nothing of the task is lost, and sym(M) > 0 at any λ."""
    row, J_b = tasks(seed, m)
    row = row - np.linalg.pinv(J_b) @ (J_b @ row)
    a = analyse(row, J_b, lam, K_a, K_b)
    assert a.orthogonal and a.independent and a.condition_holds
    assert_allclose(a.M, np.diag([K_a] + [K_b] * m), atol=1e-7)
    assert a.coupling == pytest.approx(0.0, abs=1e-7) and a.survival == pytest.approx(1.0)
    assert a.slowest_mode == pytest.approx(min(K_a, K_b)) == a.smallest_eigenvalue
    assert a.angle == pytest.approx(math.pi / 2.0)


@given(SEEDS, st.sampled_from([1, 3, 6]), st.floats(0.01, 1.0), GAINS, GAINS)
def test_a_row_inside_the_task_is_dependent(seed: int, m: int, lam: float, K_a: float, K_b: float) -> None:
    """A critical point on the hand: rank 3 < 1 + 3, eq. (15), ρ = 1, a mode at rest, and the condition fails."""
    _, J_b = tasks(seed, m)
    row = np.random.default_rng(seed + 1).normal(size=m) @ J_b
    a = analyse(row, J_b, lam, K_a, K_b)
    assert (a.rank_a, a.rank_b, a.rank_stack) == (1, m, m)
    assert not (a.independent or a.orthogonal or a.condition_holds)
    assert a.rho == pytest.approx(1.0) and a.survival == pytest.approx(1.0 - lam)
    assert a.slowest_mode == pytest.approx(0.0, abs=1e-9) and a.angle == pytest.approx(0.0, abs=1e-6)


@given(SEEDS, DIMENSIONS, GAINS, GAINS)
def test_the_task_alone(seed: int, m: int, K_a: float, K_b: float) -> None:
    """λ = 0: M_bb = K_b, e_a = 0 and the task's error falls as exp(−K_b t), however the two tasks lie."""
    row, J_b = tasks(seed, m)
    a = analyse(row, J_b, 0.0, K_a, K_b)
    assert_allclose(a.M_bb, K_b * np.eye(m), atol=1e-7)
    assert a.condition_holds and a.survival == 1.0
    e = a.error(0.3, np.random.default_rng(seed).normal(size=m))
    assert e[0] == 0.0
    assert a.lyapunov_rate(e) == pytest.approx(-2.0 * K_b * a.lyapunov(e))
    assert a.task_error_rate(e) == pytest.approx(-K_b * float(np.linalg.norm(e[1:])))
    # Positive control: the same two tasks with nearly parallel directions fail as soon as λ counts.
    assert not analyse(J_b[0] + 1e-3 * row, J_b, 0.5, K_a, K_b).condition_holds


@given(SEEDS, DIMENSIONS, GAINS, GAINS)
def test_avoidance_first(seed: int, m: int, K_a: float, K_b: float) -> None:
    """λ = 1 is strict priority, eq. (11): the task can do nothing to avoidance, M_ab = 0, for any two tasks."""
    row, J_b = tasks(seed, m)
    a = analyse(row, J_b, 1.0, K_a, K_b)
    assert_allclose(a.M_ab, 0.0, atol=1e-12)
    assert a.slowest_mode == pytest.approx(min(K_a, K_b * a.survival), rel=1e-6)


def test_a_triangular_m_is_not_a_positive_definite_one() -> None:
    """λ = 1 and independent tasks: M_ab = 0 and all eigenvalues of M positive, yet some error lets V rise."""
    J_b = np.array([[1.0, 0.0, 0.0]])
    a = analyse(np.array([0.5, 0.1, 0.0]), J_b, 1.0, 2.0, 2.0)
    assert a.independent and a.slowest_mode > 0.0 and not a.condition_holds
    assert_allclose(a.M_ab, 0.0, atol=1e-12)
    assert a.lyapunov_rate(np.linalg.eigh(sym(a.M))[1][:, 0]) > 0.1


@pytest.mark.parametrize("damped", [False, True])
@pytest.mark.parametrize("J_b", [np.random.default_rng(1).normal(size=(3, 7)), None], ids=["hand", "posture"])
@pytest.mark.parametrize("length", [0.0, 1e-9])
def test_no_lever(length: float, J_b: Array | None, damped: bool) -> None:
    """J_d = 0: avoidance has rank 0 and takes nothing; M_aa = 0 is not positive, so the condition cannot hold."""
    a = analyse(np.full(7, length), J_b, 0.8, 2.0, 3.0, damped)
    m = 7 if J_b is None else 3
    assert (a.rank_a, a.rank_b, a.rank_stack) == (0, m, m)
    assert a.survival == 1.0 and a.rho == 0.0 and a.coupling == 0.0 and a.slowest_mode == 0.0
    assert not a.condition_holds
    assert_allclose(a.M, np.diag([0.0] + [3.0] * m), atol=1e-3 if damped else 1e-12)


def test_singular_tasks() -> None:
    """A task that lost a direction, or all: the ranks say so, M is finite, the condition does not hold."""
    row, J_b = tasks(2, 3)
    J_b[2] = 2.0 * J_b[0] - J_b[1]
    a = analyse(row, J_b, 0.5, 2.0, 2.0)
    assert (a.rank_a, a.rank_b, a.rank_stack) == (1, 2, 3) and a.independent
    assert a.slowest_mode == 0.0 and not a.condition_holds
    assert_allclose(a.coupling, np.linalg.norm(row @ np.linalg.pinv(J_b)), rtol=1e-9)
    for damped in (False, True):
        nothing = analyse(row, np.zeros((3, 7)), 0.5, 2.0, 2.0, damped)
        assert (nothing.rank_b, nothing.rank_stack) == (0, 1)
        assert_allclose(nothing.M, np.diag([nothing.M[0, 0], 0.0, 0.0, 0.0]))
        assert not nothing.condition_holds


@given(SEEDS, DIMENSIONS, st.floats(1e-6, 1.5))
def test_ranks_are_those_of_singular_values(seed: int, m: int, angle: float) -> None:
    """rank [J_a; J_b] is that of numpy's decomposition of [ĵ; an orthonormal basis of J_b's rows], at any angle between them."""
    row, J_b = tasks(seed, m)
    basis = np.linalg.svd(J_b, full_matrices=False)[2]
    inside = basis[0]
    outside = row - basis.T @ (basis @ row)
    outside /= np.linalg.norm(outside)
    a = analyse(0.3 * (math.cos(angle) * inside + math.sin(angle) * outside), J_b, 0.5, 1.0, 1.0)
    assert a.angle == pytest.approx(angle, abs=1e-9)
    singular = np.linalg.svd(np.vstack((math.cos(angle) * inside + math.sin(angle) * outside, basis)))[1]
    if abs(singular[-1] / TOLERANCE - 1.0) > 1e-6:
        assert a.rank_stack == int(np.count_nonzero(singular > TOLERANCE))
        assert a.independent == (singular[-1] > TOLERANCE)


def test_gains_of_zero() -> None:
    """K = 0 is allowed on the page: M loses a block, nothing else breaks; without K_a there is no e_a that asks for λ v."""
    row, J_b = tasks(1, 3)
    for K_a, K_b in ((0.0, 2.0), (2.0, 0.0), (0.0, 0.0)):
        a = analyse(row, J_b, 0.5, K_a, K_b)
        assert np.isfinite(a.M).all() and not a.condition_holds and a.slowest_mode == 0.0
    assert math.isnan(analyse(row, J_b, 0.5, 0.0, 2.0).error(0.3, np.zeros(3))[0])


def test_an_error_of_zero_can_only_grow() -> None:
    """At e_b = 0 the rate of |e_b| is the speed at which avoidance pushes the hand away."""
    row, J_b = tasks(1, 3)
    a = analyse(row, J_b, 0.5, 2.0, 2.0)
    e = a.error(0.3, np.zeros(3))
    assert a.task_error_rate(e) == pytest.approx(float(np.linalg.norm(J_b @ row)) / float(row @ row) * 0.5 * 0.3)


@pytest.mark.parametrize(
    ("lam", "K_a", "K_b", "what"),
    [
        (-0.1, 1.0, 1.0, "λ"),
        (1.1, 1.0, 1.0, "λ"),
        (math.nan, 1.0, 1.0, "λ"),
        (0.5, -1.0, 1.0, "K_a"),
        (0.5, 1.0, math.inf, "K_b"),
    ],
)
def test_bad_settings_are_named(lam: float, K_a: float, K_b: float, what: str) -> None:
    """A λ or a gain that cannot be is named, with what could be."""
    with pytest.raises(BadSetting, match=rf"{what} is .*; it must be"):
        analyse(*tasks(1, 3), lam, K_a, K_b)


@pytest.mark.parametrize(
    ("row", "J_b"),
    [
        (np.zeros(7), np.zeros((3, 6))),
        (np.zeros((1, 7)), np.zeros((3, 7))),
        (np.zeros(7), np.zeros(7)),
        (np.zeros(7), np.zeros((0, 7))),
        (np.zeros(0), None),
        (np.full(7, np.nan), None),
        (np.zeros(7), np.full((3, 7), np.inf)),
    ],
)
def test_wrong_shapes_and_numbers_are_refused(row: Array, J_b: Array | None) -> None:
    """What is no pair of Jacobians is refused rather than analysed."""
    with pytest.raises(ValueError, match="J_d"):
        analyse(row, J_b, 0.5, 1.0, 1.0)


def test_pure() -> None:
    """Read-only inputs suffice, the result is read-only, and the same inputs give the same bits."""
    row, J_b = tasks(1, 3)
    row.flags.writeable = J_b.flags.writeable = False
    first, second = (analyse(row, J_b, 0.5, 2.0, 3.0) for _ in range(2))
    assert_array_equal(first.M, second.M)
    assert (first.smallest_eigenvalue, first.angle, first.coupling) == (second.smallest_eigenvalue, second.angle, second.coupling)
    with pytest.raises(ValueError, match="read-only"):
        first.M[0, 0] = 1.0


# ---- the barrier function -----------------------------------------------------------------------------------------------------


def integral(d: float, dm: float, n: float) -> float:
    """∫_d^∞ λ/(1 − λ) ds by quadrature over ln(s − d_m), with the first terms of the series beyond 20 m."""
    body = quad(lambda t: math.exp(t) / math.expm1(n * math.log1p(math.exp(t) / dm)), math.log(d - dm), 3.0, limit=400)[0]
    x = dm / (dm + math.exp(3.0))
    return body + dm * sum(x ** (n * k - 1.0) / (n * k - 1.0) for k in range(1, 100))


@given(st.floats(0.03, 0.3), st.floats(1.05, 20.0) | st.just(2.0), st.floats(1e-5, 2.0))
def test_barrier_integral_is_the_integral(dm: float, n: float, gap: float) -> None:
    """The closed form against quadrature, for every order above 1."""
    assert barrier_integral(dm + gap, dm, n) == pytest.approx(integral(dm + gap, dm, n), rel=1e-6)


@pytest.mark.parametrize("n", [1.0, 1.5, 2.0, 2.0 + 1e-12, 6.0, 20.0])
def test_slope_of_the_barrier(n: float) -> None:
    """dW/dd = −λ/(1 − λ) · v/|J_d|², n = 1 included, and the closed form of n = 2 is the limit of the others."""
    for d in (0.151, 0.2, 0.35, 0.9):
        h = 1e-6 * d
        slope = (barrier_integral(d + h, 0.15, n) - barrier_integral(d - h, 0.15, n)) / (2.0 * h)
        lam = (0.15 / d) ** n
        assert slope == pytest.approx(-lam / (1.0 - lam), rel=1e-4)
    assert barrier_integral(0.2, 0.15, 2.0 + 1e-12) == pytest.approx(barrier_integral(0.2, 0.15, 2.0), rel=1e-9)


def test_at_and_below_the_critical_distance() -> None:
    """W is infinite at d_m and below, for any order and lever; above it is finite, and not a number without a lever."""
    row, error = np.full(7, 0.2), np.zeros(7)
    for n in (1.0, 2.0, 6.0):
        for d in (0.15, 0.1, -0.02):
            assert barrier_integral(d, 0.15, n) == math.inf
            assert barrier(error, 2.0, row, d, 0.15, n, 0.3) == math.inf == barrier(error, 2.0, 0.0 * row, d, 0.15, n, 0.3)
        assert math.isfinite(barrier(error, 2.0, row, 0.15 + 1e-12, 0.15, n, 0.3))
        assert math.isnan(barrier(error, 2.0, np.full(7, 0.04), 0.2, 0.15, n, 0.3))
        assert n == 1.0 or barrier_integral(math.inf, 0.15, n) == 0.0
    assert barrier(np.full(7, 0.1), 2.0, row, 0.2, 0.15, 2.0, 0.0) == pytest.approx(0.07)


@dataclass(frozen=True)
class Planar:
    """A planar arm of three links; its fingertip keeps clear of a ball at rest."""

    ball: Array
    radius: float

    def tip(self, q: Array) -> Array:
        """Place (2,) of the tip."""
        angles = np.cumsum(q)
        return np.array([0.4, 0.35, 0.25]) @ np.column_stack((np.cos(angles), np.sin(angles)))

    def distance(self, q: Array) -> float:
        """d."""
        return float(np.linalg.norm(self.tip(q) - self.ball)) - self.radius

    def row(self, q: Array) -> Array:
        """J_d (3,)."""
        angles, lengths = np.cumsum(q), np.array([0.4, 0.35, 0.25])
        links = lengths[:, None] * np.column_stack((-np.sin(angles), np.cos(angles)))
        J = np.cumsum(links[::-1], axis=0)[::-1]
        away = self.tip(q) - self.ball
        return J @ (away / np.linalg.norm(away))


NEAR = Planar(np.array([0.9, 0.35]), 0.05)
"""The ball is where the arm should be: at `GOAL` d would be .114 m."""

ASIDE = Planar(np.array([0.55, 0.25]), 0.05)
"""The ball is beside the way, and |J_d| falls to a third along it."""

GOAL = np.array([0.5, 0.1, -0.1])


@pytest.mark.parametrize("arm", [NEAR, ASIDE], ids=["near", "aside"])
def test_planar_row(arm: Planar) -> None:
    """The hand-made row is the gradient of the hand-made distance."""
    for q in np.random.default_rng(1).uniform(-1.5, 1.5, (20, 3)):
        assert_allclose(arm.row(q), derivative(lambda x: np.array([arm.distance(x)]), q)[0], atol=1e-7)


@pytest.mark.parametrize("n", [1.0, 2.0, 6.0])
def test_the_law_is_a_projected_gradient_flow(n: float) -> None:
    """q̇ = −(I − λ J_d^# J_d) ∇W, ∇W by finite differences, exact for a v that grows with |J_d|²."""
    seen = 0
    for q in np.random.default_rng(2).uniform(-1.5, 1.5, (60, 3)):
        d, row = NEAR.distance(q), NEAR.row(q)
        if d < 0.16 or np.linalg.norm(row) < 1.1 * AUTHORITY:
            continue
        seen += 1

        def W(x: Array) -> Array:
            j = NEAR.row(x)
            return np.array([barrier(GOAL - x, 2.0, j, NEAR.distance(x), 0.15, n, float(j @ j))])

        law = SmoothPriority(0.15, n, float(row @ row))
        dq = law(Situation(q, 2.0 * (GOAL - q), row, d, 0.0))
        gradient = derivative(W, q)[0]
        assert_allclose(dq, -textbook_projector(row, law.activation(d)) @ gradient, atol=1e-5)
        assert float(gradient @ dq) <= 1e-6
    assert seen > 30


def frozen_run(arm: Planar, start: Array, n: float, exact: bool, steps: int = 5000) -> tuple[Array, Array, Array]:
    """W, ½ |q_r − q|² and d along a run towards `GOAL`, the ball at rest; `exact`: v grows with |J_d|², else it is .3 m/s."""
    q, dt, kept = start.copy(), 1e-3, []
    for _ in range(steps):
        row, d, error = arm.row(q), arm.distance(q), GOAL - q
        law = SmoothPriority(0.15, n, 0.6 * float(row @ row) if exact else 0.3)
        kept.append((barrier(error, 2.0, row, d, 0.15, n, law.nominal_velocity), 0.5 * float(error @ error), d))
        q = q + dt * law(Situation(q, 2.0 * error, row, d, 0.0))
    W, V, distances = np.array(kept).T
    return W, V, distances


def risen(values: Array) -> float:
    """By how much values have risen in all, against the first one."""
    return float(np.maximum(np.diff(values), 0.0).sum()) / abs(float(values[0]))


@pytest.mark.parametrize("n", [1.0, 2.0, 6.0])
@pytest.mark.parametrize("start", [(-0.6, -0.1, 0.0), (0.58, 0.1, -0.1)])
def test_w_falls_along_a_run_and_keeps_the_distance(n: float, start: tuple[float, ...]) -> None:
    """With v ∝ |J_d|² W never rises, and d stays above d_m; with the paper's constant v it hardly rises while |J_d| hardly changes."""
    W, _, distances = frozen_run(NEAR, np.array(start), n, True)
    assert np.isfinite(W).all() and W[-1] < 0.99 * W[0]
    assert np.diff(W).max() <= 1e-14
    assert distances.min() > 0.15 > NEAR.distance(GOAL)
    W, _, distances = frozen_run(NEAR, np.array(start), n, False)
    assert np.isfinite(W).all() and risen(W) < 1e-4
    assert distances.min() > 0.15


def test_where_w_falls_v_may_rise() -> None:
    """Positive control: started near its goal the arm is pushed away from it; V = ½ |q_r − q|² rises, W falls all the same."""
    W, V, _ = frozen_run(NEAR, np.array([0.58, 0.1, -0.1]), 2.0, True)
    assert risen(V) > 1.0 and risen(W) < 1e-12


def test_w_is_no_lyapunov_function_where_the_lever_changes() -> None:
    """The honest limit: |J_d| falls from .5 to .19 m/rad on the way, and under the paper's constant v W rises by more than 1 %."""
    start = np.array([1.0, 0.1, -0.8])
    rows = [float(np.linalg.norm(ASIDE.row(q))) for q in (start, GOAL)]
    assert rows[1] < 0.5 * rows[0]
    W, _, _ = frozen_run(ASIDE, start, 2.0, False)
    assert risen(W) > 0.01
    W, _, _ = frozen_run(ASIDE, start, 2.0, True)
    assert risen(W) == 0.0
