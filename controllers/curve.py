"""A λ(d) through given points: text form and interpolation."""

from bisect import bisect_right
from functools import lru_cache
from itertools import pairwise
from typing import Final, NamedTuple

from controllers.errors import BadSetting, LazyText

MOST_POINTS: Final = 48

FARTHEST: Final = 2.0
"""Largest |d| of a point [m]."""


@lru_cache(maxsize=256)
def curve_points(text: str) -> tuple[tuple[float, float], ...]:
    """Points (d [m], λ) of a text such as "0.15:1,0.2:0.3,0.4:0".

    Raises:
        BadSetting: unreadable, out of range, or distances that do not rise.
    """
    remedy = LazyText("write its points as d:λ, d in metres, with commas between them: 0.15:1,0.2:0.3,0.4:0.")
    try:
        points = tuple((float(d), float(lam)) for d, lam in (part.split(":") for part in text.split(",")))
    except ValueError:
        raise BadSetting(
            "curve = {text} cannot be read; {remedy}", text=repr(text[:60]), remedy=remedy
        ) from None
    if not 2 <= len(points) <= MOST_POINTS:
        raise BadSetting(
            "A curve has 2 to {most} points, not {count}; {remedy}",
            most=MOST_POINTS,
            count=len(points),
            remedy=remedy,
        )
    for d, lam in points:
        if not (abs(d) <= FARTHEST and 0.0 <= lam <= 1.0):
            raise BadSetting(
                "{point} is out of range; d goes from −2 to 2 m and λ from 0 to 1.", point=f"{d:g}:{lam:g}"
            )
    for (d, _), (following, _) in pairwise(points):
        if following - d < 1e-4:
            raise BadSetting(
                "The distances of a curve rise by 0.1 mm at least; {d:g} comes before {then:g}.",
                d=d,
                then=following,
            )
    return points


def curve_text(points: tuple[tuple[float, float], ...]) -> str:
    """Text of points (d [m], λ) for `curve_points`."""
    return ",".join(f"{d:.6g}:{lam:.6g}" for d, lam in points)


def read_curve(text: str) -> str:
    """Normal form of a text of points.

    Raises:
        BadSetting: see `curve_points`.
    """
    return curve_text(curve_points(text))


class PiecewiseCubic(NamedTuple):
    """A cubic between every two points, within their heights, with one slope at each point."""

    distances: tuple[float, ...]
    heights: tuple[float, ...]
    slopes: tuple[float, ...]

    def height(self, distance: float) -> float:
        """λ at a distance [m]."""
        xs = self.distances
        if distance <= xs[0]:
            return self.heights[0]
        if distance >= xs[-1]:
            return self.heights[-1]
        i = bisect_right(xs, distance) - 1
        h = xs[i + 1] - xs[i]
        s = (distance - xs[i]) / h
        rise = s * s * (3.0 - 2.0 * s)
        bend = s * (1.0 - s) * h
        from_left, from_right = self.slopes[i] * (1.0 - s), self.slopes[i + 1] * s
        lam = (
            self.heights[i] + rise * (self.heights[i + 1] - self.heights[i]) + bend * (from_left - from_right)
        )
        return min(max(lam, 0.0), 1.0)


@lru_cache(maxsize=256)
def curve_through(text: str) -> PiecewiseCubic:
    """Curve through points, monotone between any two: F. N. Fritsch and J. Butland, SIAM J. Sci. Stat.
    Comput. 5(2), 1984.
    """
    distances, heights = zip(*curve_points(text), strict=True)
    widths = [b - a for a, b in pairwise(distances)]
    rises = [(b - a) / h for (a, b), h in zip(pairwise(heights), widths, strict=True)]
    slopes = [0.0]
    for (before, after), (h, k) in zip(pairwise(rises), pairwise(widths), strict=True):
        weights = (2.0 * k + h, k + 2.0 * h)
        turns = before * after <= 0.0
        slopes.append(0.0 if turns else sum(weights) / (weights[0] / before + weights[1] / after))
    return PiecewiseCubic(distances, heights, (*slopes, 0.0))


def kept_distance(text: str) -> float | None:
    """Distance up to which λ is 1 [m], so that d stays there while w ≤ v; None if the curve begins below 1.

    Beyond it a pull u > λ v / (1 − λ) wins.
    """
    kept = None
    for distance, lam in curve_points(text):
        if lam < 1.0:
            break
        kept = distance
    return kept
