"""M of section III, and the barrier function W, against finite differences and integrals of the closed loop."""

import math
from dataclasses import dataclass
from itertools import islice

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.integrate import quad

from controllers.kinematics import Array, damped_solution, pseudo_inverse
from controllers.laws.situation import AUTHORITY, Situation
from controllers.laws.smooth_priority import SmoothPriority
from controllers.proximity import Proximity
from controllers.stability import analyse, barrier, barrier_integral
from controllers.tasks import pose_error
from tests.controllers.helpers import bodies, derivative, random_postures

LAW = SmoothPriority(0.15, 6.0, 0.3)


class LeftArm:
    """The LWR's left arm, with the right one frozen: distance and hand pose as smooth functions of q."""

    def __init__(self, q: Array) -> None:
        self.room, self.kinematics, self.detector = bodies("torso")
        self.arm = self.room.arms[0]
        self.whole, self.q = q, q[self.arm.joints]
        self.near = self.look(self.q)
        self.row = self.near.row[self.arm.joints]
        self.jacobian = self.kinematics.hand_jacobian(self.arm).copy()

    def look(self, q: Array) -> Proximity:
        whole = self.whole.copy()
        whole[self.arm.joints] = q
        self.kinematics.update(whole)
        return self.detector.detect()

    def distance(self, q: Array) -> float:
        """d of the initially closest pair."""
        self.look(q)
        return float(self.detector.distances()[self.near.pair])

    def hand(self, q: Array) -> pin.SE3:
        self.look(q)
        return self.kinematics.hand_pose(self.arm).copy()


def near_postures(count: int, seed: int, shortest: float) -> list[LeftArm]:
    """Postures with d between 0.02 and 0.6 m and |J_d| above `shortest`."""
    arms = map(LeftArm, random_postures(bodies("torso")[0], 5000, seed))
    near = (arm for arm in arms if 0.02 < arm.near.distance < 0.6 and np.linalg.norm(arm.row) > shortest)
    found = list(islice(near, count))
    assert len(found) == count
    return found


def test_m_gives_the_error_rate_of_the_closed_loop() -> None:
    """−de/dt = M e and V̇ = −eᵀ M e, by central differences of d(q) and the hand along the law's q̇.

    Both targets are held: e_a = λ v / K_a with the present λ, so the target of x_a = d is d + e_a.
    """
    random, K_a, K_b, h = np.random.default_rng(3), 5.0, 2.0, 1e-5
    rising = 0
    for left in near_postures(40, 5, AUTHORITY):
        q, near, row, J_b = left.q, left.near, left.row, left.jacobian[:3]
        e_b = random.normal(size=3) * 0.1
        goal_b = left.hand(q).translation + e_b
        analysis = analyse(row, J_b, LAW.activation(near.distance), K_a, K_b)
        e = analysis.error(LAW.nominal_velocity, e_b)
        assert e[0] == pytest.approx(LAW.activation(near.distance) * 0.3 / 5.0)
        goal_a = near.distance + e[0]
        dq = LAW(Situation(q, pseudo_inverse(J_b) @ (K_b * e_b), row, near.distance, 0.0))

        def errors(
            t: float, left: LeftArm = left, q: Array = q, dq: Array = dq, a: float = goal_a, b: Array = goal_b
        ) -> Array:
            moved = q + t * dq
            return np.array([a - left.distance(moved), *(b - left.hand(moved).translation)])

        assert_allclose(errors(0.0), e, atol=1e-12)
        forth, back = errors(h), errors(-h)
        scale = max(1.0, float(np.linalg.norm(dq)))
        assert_allclose((back - forth) / (2.0 * h), analysis.M @ e, atol=1e-6 * scale)
        assert 0.5 * (forth @ forth - back @ back) / (2.0 * h) == pytest.approx(
            analysis.lyapunov_rate(e), abs=1e-6 * scale
        )
        assert analysis.lyapunov(e) == pytest.approx(0.5 * (e @ e))
        rising += analysis.lyapunov_rate(e) > 0.0
    # Positive control: V rises at some of these moments.
    assert rising > 0


def test_with_the_laws_gain_the_avoidance_error_follows_m() -> None:
    """With K_a = −v dλ/dd, e_a = λ(d) v / K_a changes at −(M e)_a without held targets; with 2 K_a not."""
    random, h = np.random.default_rng(4), 1e-5
    apart = 0
    for left in near_postures(40, 4, AUTHORITY):
        q, near, row, J_b = left.q, left.near, left.row, left.jacobian[:3]
        if not 0.16 < near.distance < 0.35:
            continue
        slope = 0.3 * 6.0 * LAW.activation(near.distance) / near.distance
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
    """With damped inverses M e is J q̇ of the running task and law, also for singular rows; otherwise not."""
    random, m = np.random.default_rng(5), 3 if task == "position" else 6
    apart = 0.0
    for left in near_postures(40, 5, 0.0):
        q, near, row, J_b = left.q, left.near, left.row, left.jacobian[:m]
        pose = left.hand(q)
        goal = pin.SE3(
            pin.exp3(random.normal(size=3) * 0.2) @ pose.rotation,
            pose.translation + random.normal(size=3) * 0.1,
        )
        e_b = pose_error(pose, goal.translation, goal.rotation)
        nominal = damped_solution(J_b, 2.0 * e_b[:m])
        dq = LAW(Situation(q, nominal, row, near.distance, 0.0))
        damped, exact = (
            analyse(row, J_b, LAW.activation(near.distance), 2.0, 2.0, damped) for damped in (True, False)
        )
        e = damped.error(0.3, e_b[:m])
        assert_allclose(damped.M @ e, np.concatenate(((row @ dq,), J_b @ dq)), atol=1e-10)
        apart = max(apart, float(np.abs((exact.M - damped.M) @ e).max()))
        # Along the error the logarithm's rate is the angular velocity: V̇ and |e_b| are exact for poses, too.
        step = 1e-5
        there, back = (left.hand(q + t * dq) for t in (step, -step))
        lengths = [
            float(np.linalg.norm(pose_error(p, goal.translation, goal.rotation)[:m])) for p in (there, back)
        ]
        rate = -float(e[1:] @ (damped.M @ e)[1:]) / float(np.linalg.norm(e[1:]))
        assert (lengths[0] - lengths[1]) / (2.0 * step) == pytest.approx(rate, abs=1e-5)
    assert apart > 1e-3


def integral(d: float, dm: float, n: float) -> float:
    """∫_d^∞ λ/(1 − λ) ds by quadrature over ln(s − d_m), with the first terms of the series beyond 20 m."""
    body = quad(
        lambda t: math.exp(t) / math.expm1(n * math.log1p(math.exp(t) / dm)), math.log(d - dm), 3.0, limit=400
    )[0]
    x = dm / (dm + math.exp(3.0))
    return body + dm * sum(x ** (n * k - 1.0) / (n * k - 1.0) for k in range(1, 100))


@given(st.floats(0.03, 0.3), st.floats(1.05, 20.0) | st.just(2.0), st.floats(1e-5, 2.0))
def test_barrier_integral_is_the_integral(dm: float, n: float, gap: float) -> None:
    """The closed form against quadrature, for every order above 1."""
    assert barrier_integral(dm + gap, dm, n) == pytest.approx(integral(dm + gap, dm, n), rel=1e-6)


@pytest.mark.parametrize("n", [1.0, 1.5, 2.0, 2.0 + 1e-12, 6.0, 20.0])
def test_slope_of_the_barrier(n: float) -> None:
    """dW/dd = −λ/(1 − λ) · v/|J_d|², also for n = 1; the closed form of n = 2 is the limit of the others."""
    for d in (0.151, 0.2, 0.35, 0.9):
        h = 1e-6 * d
        slope = (barrier_integral(d + h, 0.15, n) - barrier_integral(d - h, 0.15, n)) / (2.0 * h)
        lam = (0.15 / d) ** n
        assert slope == pytest.approx(-lam / (1.0 - lam), rel=1e-4)
    assert barrier_integral(0.2, 0.15, 2.0 + 1e-12) == pytest.approx(
        barrier_integral(0.2, 0.15, 2.0), rel=1e-9
    )


def test_at_and_below_the_critical_distance() -> None:
    """W is infinite up to d_m, for any order and lever; above, it is finite, and nan without a lever."""
    row, error = np.full(7, 0.2), np.zeros(7)
    for n in (1.0, 2.0, 6.0):
        for d in (0.15, 0.1, -0.02):
            assert barrier_integral(d, 0.15, n) == math.inf
            assert (
                barrier(error, 2.0, row, d, 0.15, n, 0.3)
                == math.inf
                == barrier(error, 2.0, 0.0 * row, d, 0.15, n, 0.3)
            )
        assert math.isfinite(barrier(error, 2.0, row, 0.15 + 1e-12, 0.15, n, 0.3))
        assert math.isnan(barrier(error, 2.0, np.full(7, 0.04), 0.2, 0.15, n, 0.3))
        assert n == 1.0 or barrier_integral(math.inf, 0.15, n) == 0.0
    assert barrier(np.full(7, 0.1), 2.0, row, 0.2, 0.15, 2.0, 0.0) == pytest.approx(0.07)


@dataclass(frozen=True)
class Planar:
    """Planar arm of three links with a fingertip that avoids a resting ball."""

    ball: Array
    radius: float

    def tip(self, q: Array) -> Array:
        angles = np.cumsum(q)
        return np.array([0.4, 0.35, 0.25]) @ np.column_stack((np.cos(angles), np.sin(angles)))

    def distance(self, q: Array) -> float:
        return float(np.linalg.norm(self.tip(q) - self.ball)) - self.radius

    def row(self, q: Array) -> Array:
        angles, lengths = np.cumsum(q), np.array([0.4, 0.35, 0.25])
        links = lengths[:, None] * np.column_stack((-np.sin(angles), np.cos(angles)))
        J = np.cumsum(links[::-1], axis=0)[::-1]
        away = self.tip(q) - self.ball
        return J @ (away / np.linalg.norm(away))


NEAR = Planar(np.array([0.9, 0.35]), 0.05)
"""The ball blocks the goal: at `GOAL` d would be .114 m."""

ASIDE = Planar(np.array([0.55, 0.25]), 0.05)
"""The ball is next to the path, along which |J_d| falls to a third."""

GOAL = np.array([0.5, 0.1, -0.1])


@pytest.mark.parametrize("n", [1.0, 2.0, 6.0])
def test_the_law_is_a_projected_gradient_flow(n: float) -> None:
    """q̇ = −(I − λ J_d^# J_d) ∇W by finite differences, exact if v grows with |J_d|²."""
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
        N_a = np.eye(3) - law.activation(d) * pseudo_inverse(row[None, :]) @ row[None, :]
        assert_allclose(dq, -N_a @ gradient, atol=1e-5)
        assert float(gradient @ dq) <= 1e-6
    assert seen > 30


def frozen_run(
    arm: Planar, start: Array, n: float, exact: bool, steps: int = 2500
) -> tuple[Array, Array, Array]:
    """W, ½ |q_r − q|² and d of a run to `GOAL`, the ball at rest; `exact`: v ∝ |J_d|², else .3 m/s."""
    q, dt, kept = start.copy(), 1e-3, []
    for _ in range(steps):
        row, d, error = arm.row(q), arm.distance(q), GOAL - q
        law = SmoothPriority(0.15, n, 0.6 * float(row @ row) if exact else 0.3)
        kept.append(
            (barrier(error, 2.0, row, d, 0.15, n, law.nominal_velocity), 0.5 * float(error @ error), d)
        )
        q = q + dt * law(Situation(q, 2.0 * error, row, d, 0.0))
    W, V, distances = np.array(kept).T
    return W, V, distances


def risen(values: Array) -> float:
    return float(np.maximum(np.diff(values), 0.0).sum()) / abs(float(values[0]))


@pytest.mark.parametrize("n", [1.0, 2.0, 6.0])
@pytest.mark.parametrize("start", [(-0.6, -0.1, 0.0), (0.58, 0.1, -0.1)])
def test_w_falls_along_a_run_and_keeps_the_distance(n: float, start: tuple[float, ...]) -> None:
    """With v ∝ |J_d|² W never rises; with the paper's v it hardly rises while |J_d| hardly changes."""
    W, _, distances = frozen_run(NEAR, np.array(start), n, True)
    assert np.isfinite(W).all() and W[-1] < 0.99 * W[0] and np.diff(W).max() <= 1e-14
    assert distances.min() > 0.15 > NEAR.distance(GOAL)
    W, _, distances = frozen_run(NEAR, np.array(start), n, False)
    assert np.isfinite(W).all() and risen(W) < 1e-4
    assert distances.min() > 0.15


def test_where_w_falls_and_where_it_does_not() -> None:
    # Positive control: near its goal the arm is pushed away; V = ½ |q_r − q|² rises, yet W falls.
    W, V, _ = frozen_run(NEAR, np.array([0.58, 0.1, -0.1]), 2.0, True)
    assert risen(V) > 1.0 and risen(W) < 1e-12
    # Limit: |J_d| falls from .5 to .19 m/rad on the way, and with the paper's constant v W rises by over 1 %.
    start = np.array([1.0, 0.1, -0.8])
    rows = [float(np.linalg.norm(ASIDE.row(q))) for q in (start, GOAL)]
    assert rows[1] < 0.5 * rows[0]
    W, _, _ = frozen_run(ASIDE, start, 2.0, False)
    assert risen(W) > 0.01
    W, _, _ = frozen_run(ASIDE, start, 2.0, True)
    assert risen(W) == 0.0
