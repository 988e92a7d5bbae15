"""λ(d): how far avoidance has taken over, eq. (31), Petrič & Žlajpah 2011."""


def activation(distance: float, critical_distance: float, order: float) -> float:
    """Return λ(d) = (d_m / d)^n for d ≥ d_m and 1 below, eq. (31).

    Args:
        distance: d [m]; may be negative (overlap).
        critical_distance: d_m > 0 [m].
        order: n ≥ 1; the paper takes whole numbers, nothing needs that.
    """
    if distance <= critical_distance:
        return 1.0
    return (critical_distance / distance) ** order


def activation_slope(distance: float, critical_distance: float, order: float) -> float:
    """Return dλ/dd [1/m]: −n λ / d above d_m, 0 below.

    The slope jumps from 0 to −n/d_m at d_m: λ is continuous there, its derivative is not.
    """
    if distance <= critical_distance:
        return 0.0
    return -order * activation(distance, critical_distance, order) / distance
