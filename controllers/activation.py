"""The activation λ(d), eq. (31), Petrič & Žlajpah 2011, and one with a buffer."""

import math


def activation(distance: float, critical_distance: float, order: float) -> float:
    """λ(d) = (d_m / d)^n for d ≥ d_m and 1 below, eq. (31); at d_m its slope jumps from 0 to −n/d_m.

    Args:
        distance: d [m]; negative in overlap.
        critical_distance: d_m > 0 [m].
        order: n ≥ 1; a whole number in the paper.
    """
    if distance <= critical_distance:
        return 1.0
    return (critical_distance / distance) ** order


def buffered_activation(distance: float, critical_distance: float, influence_distance: float) -> float:
    """α(d): 1 up to d_m, ½ (1 + cos π (d − d_m) / (d_0 − d_m)) up to d_0, 0 beyond; continuously
    differentiable.

    Args:
        distance, critical_distance: d, d_m [m].
        influence_distance: d_0 [m]; d_0 ≤ d_m makes a hard switch at d_m.
    """
    if distance <= critical_distance:
        return 1.0
    if distance >= influence_distance:
        return 0.0
    return 0.5 * (
        1.0 + math.cos(math.pi * (distance - critical_distance) / (influence_distance - critical_distance))
    )
