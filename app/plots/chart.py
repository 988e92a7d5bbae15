"""A chart: lines in a scalable SVG, text of fixed size."""

import math
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Final

import numpy as np
from markupsafe import Markup

from app.i18n.speaking import decimal
from app.text.templates import macros
from controllers.kinematics import Array

LEAST: Final = 1e-3


_SIDE = 1000


@dataclass(frozen=True)
class ChartAxes:
    """Two axes.

    Attributes:
        x, y: first and last value.
        x_ticks, y_ticks: positions and texts of grid lines.
    """

    x: tuple[float, float]
    y: tuple[float, float]
    x_ticks: tuple[tuple[float, str], ...]
    y_ticks: tuple[tuple[float, str], ...]

    def across(self, value: float) -> float:
        return (value - self.x[0]) / (self.x[1] - self.x[0])

    def down(self, value: float) -> float:
        return (self.y[1] - value) / (self.y[1] - self.y[0])


@dataclass
class Chart:
    frame: ChartAxes
    _lines: list[tuple[str, str, str, str]] = field(default_factory=list)
    _marks: list[tuple[str, str, str, str]] = field(default_factory=list)

    def line(self, xs: Array, ys: Array, kind: str, width: float, dash: str = "") -> None:
        """Add a line, without points on straight pieces.

        Args:
            xs, ys: (points,), ascending xs; nan in ys makes a gap.
            kind: CSS class that gives the `color`.
            width, dash: [px].
        """
        known = ~np.isnan(ys)
        if not known.any():
            return
        xs, ys = xs[known], ys[known]
        (x0, x1), (y0, y1) = self.frame.x, self.frame.y
        # Points far outside the frame are invisible, and large numbers cost bytes.
        y = np.minimum(np.maximum((y1 - ys) / (y1 - y0), -1.0), 2.0)
        points = _without_middles((np.column_stack([(xs - x0) / (x1 - x0), y]) * _SIDE).tolist())
        path = "M" + " ".join(f"{px:.0f} {py:.0f}" for px, py in points)
        self._lines.append((kind, path, f"{width:g}", dash))

    def dots(self, xs: Array, ys: Array, kind: str, width: float) -> None:
        places = [
            (self.frame.across(x), self.frame.down(y))
            for x, y in zip(xs.tolist(), ys.tolist(), strict=True)
            if y == y
        ]
        path = "".join(f"M{px * _SIDE:.0f} {py * _SIDE:.0f}h0" for px, py in places)
        self._lines.append((f"{kind} dots", path, f"{width:g}", ""))

    def level(self, y: float, kind: str, width: float, dash: str = "") -> None:
        self.line(np.array(self.frame.x), np.array([y, y]), kind, width, dash)

    def mark(self, x: float, y: float, kind: str, text: str = "") -> None:
        """Add a mark, kept inside the frame."""
        left, top = self.frame.across(x), self.frame.down(y)
        left, top = min(max(left, 0.0), 1.0), min(max(top, 0.0), 1.0)
        self._marks.append((kind, f"{100 * left:.1f}", f"{100 * top:.1f}", text))

    def html(self, height: int) -> Markup:
        """HTML of this height [CSS px]; the width follows the page."""
        frame = self.frame
        grid = "".join(f"M{frame.across(x) * _SIDE:.0f} 0v{_SIDE}" for x, _ in frame.x_ticks)
        grid += "".join(f"M0 {frame.down(y) * _SIDE:.0f}h{_SIDE}" for y, _ in frame.y_ticks)
        x_texts = [(f"{100 * frame.across(x):.1f}", decimal(text)) for x, text in frame.x_ticks]
        y_texts = [(f"{100 * frame.down(y):.1f}", decimal(text)) for y, text in frame.y_ticks]
        return macros("plots/charts.html").chart(
            height, _SIDE, grid, self._lines, self._marks, x_texts, y_texts
        )


def _without_middles(points: list[list[float]]) -> list[list[float]]:
    """Points without those on a straight line, within a third of a thousandth."""
    kept = points[:1]
    for (x, y), (x2, y2) in pairwise(points[1:]):
        x1, y1 = kept[-1]
        along, across = x2 - x1, y2 - y1
        if abs((x - x1) * across - (y - y1) * along) > 0.33 * (abs(along) + abs(across)):
            kept.append([x, y])
    return kept + points[-1:]


def ticks_of(low: float, high: float) -> tuple[tuple[float, str], ...]:
    size = max(high - low, LEAST)
    step = 10.0 ** math.floor(math.log10(size / 2.0))
    step *= next(k for k in (1.0, 2.0, 5.0, 10.0) if size / (k * step) <= 5.0)
    first = math.ceil(low / step)
    numbers = range(first, math.floor(high / step) + 1)
    digits = max(0, -math.floor(math.log10(step) + 1e-9))
    return tuple((i * step, f"{i * step:.{digits}f}".replace("-", "−")) for i in numbers)
