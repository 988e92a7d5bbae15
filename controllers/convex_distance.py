"""A distance between capsules that is smooth also where their axes are parallel.

There the true distance has a kink: the closest points jump from one end to the other. A strictly convex
problem avoids it. With half axes a, b, centres c_a, c_b and r = c_a − c_b,

    F = min over s, t in [−1, 1] of |r + s a − t b|² + (ε/4) (s² + t²),      D = √F,      d = D − √(ε/2) − (r_a + r_b).

The minimiser is unique and Lipschitz continuous in q, so D has a Lipschitz gradient wherever F > 0, that of
fixed s, t (envelope theorem). As F ≤ |r + s a − t b|² + ε/2, d never exceeds the true distance. Related:
strictly convex bounding volumes (Escande et al., IEEE T-RO 30(3), 2014).
"""

import math
from typing import Final

from controllers.compiled import Vector, loop

LEAST_SQUARE: Final = 1e-12
"""Least F [m²]: where two axes cross in their middle, the gradient is 0, not 0/0."""


@loop("UniTuple(float64, 7)(float64[:], float64[:], float64, float64, float64)")
def convex_closest(
    first: Vector, second: Vector, half_a: float, half_b: float, epsilon: float
) -> tuple[float, float, float, float, float, float, float]:
    """Point on the first body's axis [m], vector to the point on the second's [m], and D [m].

    Args:
        first, second: unit axis and centre of a body (6,), world [m].
        half_a, half_b: half lengths of the axes [m]; 0 for a sphere.
        epsilon: ε > 0 [m²].
    """
    ax, ay, az = half_a * first[0], half_a * first[1], half_a * first[2]
    bx, by, bz = half_b * second[0], half_b * second[1], half_b * second[2]
    rx, ry, rz = first[3] - second[3], first[4] - second[4], first[5] - second[5]
    share = 0.25 * epsilon
    aa, bb = half_a * half_a + share, half_b * half_b + share
    ab, ar, br = ax * bx + ay * by + az * bz, ax * rx + ay * ry + az * rz, bx * rx + by * ry + bz * rz
    # The unconstrained s, the best t for it, the best s for that: exact for a strictly convex function of two variables.
    s = min(max((ab * br - bb * ar) / (aa * bb - ab * ab), -1.0), 1.0)
    t = min(max((ab * s + br) / bb, -1.0), 1.0)
    s = min(max((ab * t - ar) / aa, -1.0), 1.0)
    gx, gy, gz = t * bx - s * ax - rx, t * by - s * ay - ry, t * bz - s * az - rz
    F = gx * gx + gy * gy + gz * gz + share * (s * s + t * t)
    return (
        first[3] + s * ax,
        first[4] + s * ay,
        first[5] + s * az,
        gx,
        gy,
        gz,
        math.sqrt(max(F, LEAST_SQUARE)),
    )
