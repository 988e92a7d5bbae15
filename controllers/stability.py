"""Section III of the paper at one moment: M, ranks and V, eqs (14)–(25), and results of ours.

For two tasks with targets at rest, eq. (12) with ẋ_a = K_a e_a, ẋ_b = K_b e_b and N'_a = I − λ J_a^# J_a
gives, with e = (e_a, e_b) and V = ½ eᵀ e, eqs (17)–(25),

    ė = −M e,   V̇ = −eᵀ M e,   M = [[J_a J_a^# K_a,  J_a N'_a J_b^# K_b], [J_b J_a^# K_a,  J_b N'_a J_b^# K_b]].

Avoidance is one row, J_a = J_d, with the unit vector ĵ = J_dᵀ/|J_d|. With full ranks

    M = [[K_a,            (1 − λ) J_d J_b^# K_b], [J_b J_d^# K_a,  (I − λ J_b J_d^# J_d J_b^#) K_b]].

In eq. (32) avoidance has a speed λ v instead of a target, so e_a is defined by K_a e_a = λ v. ė = −M e is
exact while x_a + e_a is held, for any K_a. With K_a = −v dλ/dd, the gain of eq. (31) above d_m, it is also
exact for e_a = λ(d) v / K_a.

Let ρ = |Π_b ĵ|, with Π_b the projector on the row space of J_b: the cosine of the angle between avoidance and
task. With e_a in units of |J_d| and e_b in the metric e_bᵀ (J_b J_bᵀ)⁻¹ e_b, only the direction Π_b ĵ is
coupled to e_a, by

    [[K_a, (1 − λ) ρ K_b], [ρ K_a, (1 − λ ρ²) K_b]],   trace K_a + (1 − λ ρ²) K_b,   determinant K_a K_b (1 − ρ²);

the rest of M is K_b. So avoidance leaves 1 − λ ρ² of the task in its worst direction. The eigenvalues of M
are real; whatever λ, they are positive if and only if ρ < 1 (independent tasks, eq. (14)). sym(M) > 0
requires more (for K_a = K_b in this metric: ρ² < 1 / (1 + λ²/4)), so errors often decay where the paper's
condition fails. At λ = 1 M is triangular, but sym(M) need not be positive definite.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.special import hyp2f1

from controllers.errors import BadSetting
from controllers.kinematics import DAMPING, Array
from controllers.laws.situation import AUTHORITY, row_damping
from controllers.limits import FELT

TOLERANCE: Final = 1e-3
"""Relative singular values below this count as 0: directions within a milliradian are the same."""


@dataclass(frozen=True, eq=False)
class Analysis:
    """Two tasks at one moment: a, avoidance (one row), and b, the task of the arm (m dimensions).

    M and results from it depend on the units of e if these are mixed (rad with m). Ranks, `angle`, ρ,
    `survival` and `slowest_mode` do not, and always use the exact inverses.

    Attributes:
        M: (1 + m, 1 + m) [1/s where the units agree], eq. (25), read-only. Blocks: M_aa M[:1, :1], M_ab M[:1,
            1:] (effect of the task on avoidance), M_ba M[1:, :1], M_bb M[1:, 1:].
        activation: λ.
        gain_a, gain_b: K_a, K_b [1/s].
        joint_task: task b is a posture, J_b = I.
        lever: |J_d| [m/rad].
        smallest_eigenvalue: of sym(M) = (M + Mᵀ)/2 [1/s].
        slowest_mode: smallest eigenvalue of M [1/s]. With M held, errors decay if and only if it is positive;
            it is 0 if and only if the tasks are dependent, one is singular or a gain is 0.
        rank_a, rank_b, rank_stack: of J_a, J_b and [J_a; J_b], eqs (14), (15).
        coupling: ‖J_a J_b^#‖, eq. (16), spectral norm.
        angle: between J_d and the row space of J_b [rad]; π/2 for J_d = 0.
        rho: ρ, its cosine.
        survival: 1 − λ ρ², the smallest eigenvalue of K_b⁻¹ M_bb in the metric e_bᵀ (J_b J_bᵀ)⁻¹ e_b.
    """

    M: Array
    activation: float
    gain_a: float
    gain_b: float
    joint_task: bool
    lever: float
    smallest_eigenvalue: float
    slowest_mode: float
    rank_a: int
    rank_b: int
    rank_stack: int
    coupling: float
    angle: float
    rho: float
    survival: float

    @property
    def independent(self) -> bool:
        """True if rank J_a + rank J_b = rank [J_a; J_b], eq. (14); else eq. (15)."""
        return self.rank_stack == self.rank_a + self.rank_b

    @property
    def orthogonal(self) -> bool:
        """True if J_a J_b^# = 0, eq. (16); then M = diag(K_a, K_b I), and the paper proves V̇ < 0."""
        return self.rho < TOLERANCE

    @property
    def condition_holds(self) -> bool:
        """True if V̇ < 0 for every e ≠ 0, the paper's sufficient condition: sym(M) > 0; at λ = 0 (e_a = 0)
        M_bb decides.
        """
        least = self.smallest_eigenvalue
        if self.activation == 0.0:
            M_bb = self.M[1:, 1:]
            least = float(np.linalg.eigvalsh(0.5 * (M_bb + M_bb.T))[0])
        return least > 1e-9 * max(self.gain_a, self.gain_b)

    def error(self, nominal_velocity: float, task_error: Array) -> Array:
        """e = (e_a, e_b) (1 + m,), with e_a = λ v / K_a; nan for K_a = 0.

        Args:
            nominal_velocity: v [m/s]; v + w with feed-forward.
            task_error: e_b (m,).
        """
        asked = self.activation * nominal_velocity
        e_a = asked / self.gain_a if self.gain_a > 0.0 else math.nan
        return np.concatenate(((e_a,), task_error))

    def lyapunov(self, error: Array) -> float:
        """V = ½ eᵀ e, eq. (20)."""
        return 0.5 * float(error.dot(error))

    def lyapunov_rate(self, error: Array) -> float:
        """V̇ = −eᵀ M e, eq. (25), if targets and obstacle are at rest and no bound is active."""
        return -float(error.dot(self.M.dot(error)))


def analyse(
    row: Array, task_jacobian: Array | None, lam: float, gain_a: float, gain_b: float, damped: bool = False
) -> Analysis:
    """Section III's quantities at one moment.

    Args:
        row: J_a = J_d (n,) [m/rad]; 0 if shorter than 1e-6 m/rad.
        task_jacobian: J_b (m, n); None for a posture task, J_b = I.
        lam: λ in [0, 1].
        gain_a, gain_b: K_a, K_b ≥ 0 [1/s].
        damped: False: the paper's Moore–Penrose inverses. True: M and `smallest_eigenvalue` use the damped
            inverses of the running laws (`tasks.hold`, `laws.situation.along_row`).

    Raises:
        BadSetting: λ outside [0, 1], or a gain negative or not finite.
        ValueError: wrong shapes, or an entry is not finite.
    """
    if not 0.0 <= lam <= 1.0:
        raise BadSetting(f"the activation λ is {lam:g}; it must be between 0 and 1")
    for name, gain in (("K_a", gain_a), ("K_b", gain_b)):
        if not 0.0 <= gain < math.inf:
            raise BadSetting(f"the gain {name} is {gain:g}; it must be a number from 0 upwards")
    shape = None if task_jacobian is None else task_jacobian.shape
    if (
        row.ndim != 1
        or not row.size
        or (shape is not None and (len(shape) != 2 or not shape[0] or shape[1] != len(row)))
    ):
        raise ValueError(f"J_d must be (n,) and J_b (m, n); they are {row.shape} and {shape}")
    if not (np.isfinite(row).all() and (task_jacobian is None or np.isfinite(task_jacobian).all())):
        raise ValueError("an entry of J_d or J_b is not finite")

    square = float(row.dot(row))
    lever = math.sqrt(square)
    rank_a = int(lever > FELT)
    j = row if rank_a else np.zeros_like(row)
    j_sharp = j / (square + (row_damping(square) if damped else 0.0)) if rank_a else j

    # The task seen by M: J_b J_b^#, J_b J_d^# and J_d J_b^#; then by eq. (16) and ρ, which always take the exact inverse.
    if task_jacobian is None:
        m = rank_b = len(row)
        own, onto_task, onto_row = np.eye(m), j_sharp, j
        coupling, sine, rho = (lever, 0.0, 1.0) if rank_a else (0.0, 1.0, 0.0)
    else:
        m = len(task_jacobian)
        U, s, Vt = np.linalg.svd(task_jacobian, full_matrices=False)
        rank_b = int(np.count_nonzero(s > TOLERANCE * s[0]))
        U_, s_, Vt_ = U[:, :rank_b], s[:rank_b], Vt[:rank_b]
        along = Vt_.dot(j)
        coupling = math.sqrt(float(((along / s_) ** 2).sum()))
        across = j - along.dot(Vt_)
        sine, rho = (
            (np.hypot.reduce(across) / lever, np.hypot.reduce(along) / lever) if rank_a else (1.0, 0.0)
        )
        J_sharp = (Vt.T * (s / (s * s + DAMPING**2))).dot(U.T) if damped else (Vt_.T / s_).dot(U_.T)
        own, onto_task, onto_row = task_jacobian.dot(J_sharp), task_jacobian.dot(j_sharp), j.dot(J_sharp)

    own_a = float(j.dot(j_sharp))
    M = np.empty((1 + m, 1 + m))
    M[0, 0] = own_a * gain_a
    M[0, 1:] = onto_row * ((1.0 - lam * own_a) * gain_b)
    M[1:, 0] = onto_task * gain_a
    M[1:, 1:] = (own - lam * np.outer(onto_task, onto_row)) * gain_b
    M.flags.writeable = False

    angle, rho = math.atan2(sine, rho), min(float(rho), 1.0)
    # The smallest singular value of [ĵ; Vt_], the others being 1 or more, is √(1 − ρ): no second decomposition is needed.
    lost = sine / math.sqrt(1.0 + rho) <= TOLERANCE
    survival = 1.0 - lam * rho * rho
    singular = rank_a == 0 or rank_b < m
    return Analysis(
        M,
        lam,
        gain_a,
        gain_b,
        task_jacobian is None,
        lever,
        float(np.linalg.eigvalsh(0.5 * (M + M.T))[0]),
        0.0 if singular else _slowest_mode(gain_a, gain_b, survival, float(sine)),
        rank_a,
        rank_b,
        rank_b + (0 if lost else rank_a),
        coupling,
        angle,
        rho,
        survival,
    )


def _slowest_mode(gain_a: float, gain_b: float, survival: float, sine: float) -> float:
    """Smaller eigenvalue of the coupled block; the others are K_b."""
    trace, determinant = gain_a + gain_b * survival, gain_a * gain_b * sine * sine
    # t² − 4 D = (K_a − K_b (1 − λ ρ²))² + 4 K_a K_b ρ² (1 − λ) is never negative, but for rounding.
    larger_twice = trace + math.sqrt(max(trace * trace - 4.0 * determinant, 0.0))
    return 2.0 * determinant / larger_twice if larger_twice > 0.0 else 0.0


def barrier(
    joint_error: Array,
    gain: float,
    row: Array,
    distance: float,
    critical_distance: float,
    order: float,
    nominal_velocity: float,
) -> float:
    """W = K/2 |q_r − q|² + (v / |J_d|²) ∫_d^∞ λ/(1 − λ) ds [rad²/s], a Lyapunov function of eq. (32) for a
    posture task.

    Ours. With q̇_n = K (q_r − q), eq. (32) is the projected gradient flow q̇ = −(I − λ J_d^# J_d) ∇W, so that
    Ẇ = −∇Wᵀ (I − λ J_d^# J_d) ∇W ≤ 0. W is infinite at d_m; while it does not grow, d > d_m.

    Requires a posture task (a hand task q̇_n = J_b^# K e_b is not a gradient), obstacle and q_r at rest, one
    differentiable d above d_m, no active bound, no feed-forward, not one-sided, and v proportional to |J_d|².
    For a constant v, W may rise by several percent where |J_d| falls to a third.

    Args:
        joint_error: q_r − q (n,) [rad].
        gain: K [1/s].
        row: J_d (n,) [m/rad].
        distance: d of the law [m].
        critical_distance: d_m > 0 [m].
        order: n ≥ 1. For n = 1 only differences of W are meaningful.
        nominal_velocity: v [m/s].

    Returns:
        inf for d ≤ d_m; nan for |J_d| < 0.12 m/rad, where J_d^# is damped.
    """
    if distance <= critical_distance:
        return math.inf
    square = float(row.dot(row))
    if square < AUTHORITY * AUTHORITY:
        return math.nan
    spring = 0.5 * gain * float(joint_error.dot(joint_error))
    return spring + nominal_velocity / square * barrier_integral(distance, critical_distance, order)


def barrier_integral(distance: float, critical_distance: float, order: float) -> float:
    """∫_d^∞ λ/(1 − λ) ds [m] for λ = (d_m/s)ⁿ; inf for d ≤ d_m.

    With x = d_m/d it is d_m Σ_k x^(n k − 1) / (n k − 1), k = 1, 2, …; for n = 2 (d_m/2) ln((d + d_m)/(d −
    d_m)), otherwise Gauss's hypergeometric function. For n = 1 it diverges: there the upper limit is 2 d_m.
    """
    if distance <= critical_distance:
        return math.inf
    if order == 1.0:
        return -critical_distance * math.log((distance - critical_distance) / critical_distance)
    if order == 2.0:
        return 0.5 * critical_distance * math.log1p(2.0 * critical_distance / (distance - critical_distance))
    x, b = critical_distance / distance, 1.0 - 1.0 / order
    return critical_distance * x ** (order - 1.0) / (order - 1.0) * float(hyp2f1(1.0, b, 1.0 + b, x**order))
