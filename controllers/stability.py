"""Section III of the paper at one moment: M, ranks and V, eqs (14)–(25), and results beyond the paper's
condition.

Derivation. Two tasks with targets at rest, e = (e_a, e_b), so that ė = −[J_a; J_b] q̇, eqs (17)–(19). Eq.
(12) closed by feedback, ẋ_a = K_a e_a and ẋ_b = K_b e_b, says

    q̇ = J_a^# K_a e_a + N'_a J_b^# K_b e_b,      N'_a = I − λ J_a^# J_a.

Insert it, with V = ½ eᵀ e, eqs (20)–(25):

    ė = −M e,   V̇ = −eᵀ M e,   M = [[J_a J_a^# K_a,  J_a N'_a J_b^# K_b], [J_b J_a^# K_a,  J_b N'_a J_b^# K_b]].

Avoidance is one row, J_a = J_d, with the unit vector ĵ = J_dᵀ/|J_d|. With full ranks J_a J_a^# = 1 and J_b
J_b^# = I, therefore

    M = [[K_a,            (1 − λ) J_d J_b^# K_b], [J_b J_d^# K_a,  (I − λ J_b J_d^# J_d J_b^#) K_b]].

The avoidance task of eq. (32) has no target: it asks for the speed λ v. It is given the error that asks for
the same, K_a e_a = λ v. Then ė = −M e is exact for a target x_a + e_a that is held for the moment, whatever
K_a. With K_a = −v dλ/dd at the present d, the gain that eq. (31) really has above d_m, it is exact for e_a =
λ(d) v / K_a as it moves.

What decides. Let ρ = |Π_b ĵ|, Π_b the projector on the row space of J_b: the cosine of the angle between
avoidance and the task. Measure e_a in units of |J_d| and e_b in the metric e_bᵀ (J_b J_bᵀ)⁻¹ e_b. Then only
the direction Π_b ĵ is coupled to e_a, by

    [[K_a, (1 − λ) ρ K_b], [ρ K_a, (1 − λ ρ²) K_b]],   trace K_a + (1 − λ ρ²) K_b,   determinant K_a K_b (1 − ρ²),

and the rest of M is K_b. So the part of the task that survives avoidance is 1 − λ ρ² in its worst direction;
every eigenvalue of M is real, and positive if and only if ρ < 1, that is if the tasks are independent, eq.
(14), whatever λ. sym(M) > 0 asks for more (with K_a = K_b in this metric: ρ² < 1 / (1 + λ²/4)), which is why
errors die out so often where the paper's condition fails. At λ = 1 the block J_a N'_a J_b^# K_b is 0 for any
two tasks; this makes M triangular, not sym(M) positive definite.
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
"""Relative singular values below this count as 0: directions within a milliradian count as one."""


@dataclass(frozen=True, eq=False)
class Analysis:
    """Two tasks at one moment: a, avoidance (one row), and b, what the arm was asked to do (m dimensions).

    M and what follows from it depend on the units of e where these are mixed (rad with m). Ranks, `angle`, ρ,
    `survival` and `slowest_mode` do not, and are always those of the exact inverses.

    Attributes:
        M: (1 + m, 1 + m) [1/s where the units agree], eq. (25), read-only. M_aa is M[:1, :1], M_ab M[:1, 1:]
            (what the task does to avoidance), M_ba M[1:, :1] and M_bb M[1:, 1:].
        activation: λ.
        gain_a, gain_b: K_a, K_b [1/s].
        joint_task: task b is a posture, J_b = I.
        lever: |J_d| [m/rad].
        smallest_eigenvalue: of sym(M) = (M + Mᵀ)/2 [1/s].
        slowest_mode: smallest eigenvalue of M itself [1/s]: 0 if and only if the tasks are dependent, one of
            them is singular or a gain is 0. The errors of ė = −M e with M held die out if and only if it is
            positive.
        rank_a, rank_b, rank_stack: of J_a, J_b and [J_a; J_b], eqs (14), (15).
        coupling: ‖J_a J_b^#‖, eq. (16), spectral norm.
        angle: between J_d and the row space of J_b [rad], π/2 for orthogonal tasks and where J_d = 0.
        rho: ρ = |Π_b J_dᵀ| / |J_d|, its cosine.
        survival: 1 − λ ρ², the smallest eigenvalue of K_b⁻¹ M_bb in the metric e_bᵀ (J_b J_bᵀ)⁻¹ e_b, where
            M_bb is symmetric.
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
        """True if rank J_a + rank J_b = rank [J_a; J_b], eq. (14); otherwise dependent, eq. (15)."""
        return self.rank_stack == self.rank_a + self.rank_b

    @property
    def orthogonal(self) -> bool:
        """True if J_a J_b^# = 0, eq. (16). Then M = diag(K_a, K_b I), for which the paper proves V̇ < 0."""
        return self.rho < TOLERANCE

    @property
    def condition_holds(self) -> bool:
        """True if V̇ < 0 for every error e ≠ 0, the paper's sufficient condition: sym(M) > 0.

        Orthogonal tasks satisfy it if no Jacobian is singular and the gains are positive. At λ = 0 the paper
        has e_a = 0, so that M_bb decides.
        """
        least = self.smallest_eigenvalue
        if self.activation == 0.0:
            M_bb = self.M[1:, 1:]
            least = float(np.linalg.eigvalsh(0.5 * (M_bb + M_bb.T))[0])
        return least > 1e-9 * max(self.gain_a, self.gain_b)

    def error(self, nominal_velocity: float, task_error: Array) -> Array:
        """e = (e_a, e_b) (1 + m,), with e_a = λ v / K_a; nan for K_a = 0, which cannot ask for any speed.

        Args:
            nominal_velocity: v [m/s]; v + w if w is fed forward.
            task_error: e_b (m,).
        """
        asked = self.activation * nominal_velocity
        e_a = asked / self.gain_a if self.gain_a > 0.0 else math.nan
        return np.concatenate(((e_a,), task_error))

    def lyapunov(self, error: Array) -> float:
        """V = ½ eᵀ e, eq. (20), for e (1 + m,)."""
        return 0.5 * float(error.dot(error))

    def lyapunov_rate(self, error: Array) -> float:
        """V̇ = −eᵀ M e, eq. (25), for e (1 + m,), if targets and obstacle are at rest and no bound changes
        the law's velocity.
        """
        return -float(error.dot(self.M.dot(error)))


def analyse(
    row: Array, task_jacobian: Array | None, lam: float, gain_a: float, gain_b: float, damped: bool = False
) -> Analysis:
    """Section III's quantities at one moment.

    Args:
        row: J_a = J_d (n,) [m/rad]; shorter than 1e-6 m/rad it counts as 0.
        task_jacobian: J_b (m, n), or None for a posture task, J_b = I.
        lam: λ in [0, 1].
        gain_a, gain_b: K_a, K_b ≥ 0 [1/s].
        damped: False: the paper's Moore–Penrose inverses. True: M, and with it `smallest_eigenvalue`, has the
            damped inverses of the running laws (`tasks.hold`, `laws.situation.along_row`), so that V̇ is
            theirs also near singular postures.

    Raises:
        BadSetting: λ outside [0, 1], or a gain that is negative or not finite.
        ValueError: the shapes do not match, or an entry is not finite.
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
    """Smaller root of x² − t x + D with t = K_a + K_b (1 − λ ρ²) and D = K_a K_b (1 − ρ²); the other modes
    are K_b.
    """
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

    Ours, not the paper's. With q̇_n = K (q_r − q), eq. (32) is the projected gradient flow q̇ = −(I − λ J_d^#
    J_d) ∇W, so that Ẇ = −∇Wᵀ (I − λ J_d^# J_d) ∇W ≤ 0; as W is infinite at d_m, a W that does not grow keeps
    d > d_m.

    It needs a posture task, obstacle and q_r at rest, one differentiable d above d_m, no active bound, no
    feed-forward and not one-sided. It treats v / |J_d|² as constant, which is exact for a law whose v grows
    with |J_d|². For a constant v, W hardly rises while |J_d| hardly changes, but may rise by several percent
    where |J_d| falls to a third. A hand task q̇_n = J_b^# K e_b is not a gradient and has no W.

    Args:
        joint_error: q_r − q (n,) [rad].
        gain: K [1/s].
        row: J_d (n,) [m/rad].
        distance: d that the law acts on [m].
        critical_distance: d_m > 0 [m].
        order: n ≥ 1. For n = 1 only differences of W are meaningful, see `barrier_integral`.
        nominal_velocity: v [m/s].

    Returns:
        inf for d ≤ d_m; nan for |J_d| < 0.12 m/rad, where the law damps J_d^# and is not such a flow.
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
    d_m)), otherwise Gauss's hypergeometric function. For n = 1 it diverges; there it ends at 2 d_m and is
    negative beyond.
    """
    if distance <= critical_distance:
        return math.inf
    if order == 1.0:
        return -critical_distance * math.log((distance - critical_distance) / critical_distance)
    if order == 2.0:
        return 0.5 * critical_distance * math.log1p(2.0 * critical_distance / (distance - critical_distance))
    x, b = critical_distance / distance, 1.0 - 1.0 / order
    return critical_distance * x ** (order - 1.0) / (order - 1.0) * float(hyp2f1(1.0, b, 1.0 + b, x**order))
