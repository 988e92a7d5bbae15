"""The distance budget and its closed forms.

Insert eq. (32) into ḋ = J_d q̇ − w with u = −J_d q̇_n: while J_d is not singular and no joint limit acts,

    ḋ = λ(d) v − (1 − λ(d)) u − w                                                                 (R)

for every arm, task and motion orthogonal to J_d. As in the paper u and w are positive *towards* the other
body. Distances in m, speeds in m/s.
"""

import math

from controllers.activation import activation


def distance_rate(lam: float, nominal_velocity: float, pull: float, approach: float) -> float:
    """ḋ [m/s], line (R)."""
    return lam * nominal_velocity - (1.0 - lam) * pull - approach


def resting_distance(
    critical_distance: float,
    order: float,
    nominal_velocity: float,
    pull: float,
    approach: float = 0.0,
    lever: float = 1.0,
) -> float:
    """Rest of line (R): d* = d_m [s (u + v) / (u + w)]^(1/n) [m], with λ(d*) = (u + w) / [s (u + v)].

    The lever s is the share of each requested change that a law gets, 1 while J_d is regular. inf if nothing
    pulls the bodies together (u + w ≤ 0). nan without a stable rest: w > v, or s is too small.
    """
    if pull + approach <= 0.0:
        return math.inf
    if approach > nominal_velocity or pull + nominal_velocity <= 0.0:
        return math.nan
    ratio = lever * ((pull + nominal_velocity) / (pull + approach))
    return critical_distance * ratio ** (1.0 / order) if ratio >= 1.0 else math.nan


def distance_loss_rate(nominal_velocity: float, approach: float) -> float:
    """Speed w − v [m/s] at which d falls while λ = 1; 0 if it does not."""
    return max(0.0, approach - nominal_velocity)


def settling_time(
    critical_distance: float, order: float, nominal_velocity: float, pull: float, approach: float = 0.0
) -> float:
    """Time constant of line (R) linearised at its rest, d* / [n (u + w)] [s]; nan or inf with d*."""
    rest = resting_distance(critical_distance, order, nominal_velocity, pull, approach)
    return rest / (order * (pull + approach)) if math.isfinite(rest) else rest


def largest_step(critical_distance: float, order: float, nominal_velocity: float, pull: float) -> float:
    """Stability limit of explicit Euler at d_m, dt < 2 d_m / [n (v + u)] [s]; below half of it d does not
    overshoot.

    At a given rest it is twice the `settling_time`.
    """
    speed = order * (nominal_velocity + pull)
    return 2.0 * critical_distance / speed if speed > 0.0 else math.inf


def largest_dead_time(settling: float, lag: float = 0.0) -> float:
    """Dead time below which line (R), linearised at its rest, is stable [s]: π/2 of `settling` without a lag.

    The robot's part of ḋ = −a (d − d*), a = 1/`settling`, is delayed by a dead time T and a first-order lag
    τ. The stability limit is a = ω √(1 + ω² τ²) with ω T + arctan ω τ = π/2.

    Args:
        settling: `settling_time` [s].
        lag: τ [s].
    """
    if settling == math.inf:
        return math.inf
    if lag == 0.0:
        return 0.5 * math.pi * settling
    omega = math.sqrt(0.5 * (math.sqrt(1.0 + (2.0 * lag / settling) ** 2) - 1.0)) / lag
    return (0.5 * math.pi - math.atan(omega * lag)) / omega


def largest_dead_time_without_overshoot(settling: float) -> float:
    """Dead time up to which line (R), linearised and without lag, does not overshoot [s]: 1/e of `settling`."""
    return settling / math.e


def far_bias_speed(distance: float, critical_distance: float, order: float, nominal_velocity: float) -> float:
    """λ(d) v, the speed at which an idle arm is still pushed away [m/s]."""
    return activation(distance, critical_distance, order) * nominal_velocity
