"""M of section III against finite differences of the closed loop."""

from itertools import islice

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose

from controllers.activation import activation_slope
from controllers.kinematics import Array, damped_solution, pseudo_inverse
from controllers.laws.situation import AUTHORITY, Situation
from controllers.laws.smooth_priority import SmoothPriority
from controllers.proximity import Proximity
from controllers.stability import analyse
from controllers.tasks import pose_error
from tests.controllers.helpers import bodies, random_postures

LAW = SmoothPriority(0.15, 6.0, 0.3)


class LeftArm:
    """The LWR's left arm, the right one frozen beside it: two smooth functions of q, and the law that moves it."""

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
        """d of the pair that was closest at first."""
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
    """−de/dt = M e by central differences of d(q) and the hand's place along the law's q̇, and V̇ = −eᵀ M e with them.

    Exact setting: both targets held; e_a = λ v / K_a with the λ of the moment, so that the target of x_a = d is d + e_a.
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
        q, near, row, J_b = left.q, left.near, left.row, left.jacobian[:3]
        slope = -0.3 * activation_slope(near.distance, 0.15, 6.0)
        if not 0.16 < near.distance < 0.35:
            continue
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
        q, near, row, J_b = left.q, left.near, left.row, left.jacobian[:m]
        pose = left.hand(q)
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
