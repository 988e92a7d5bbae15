"""Curves over one pair of axes, as an SVG."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Final, NamedTuple

from markupsafe import Markup

from app.i18n.speaking import decimal
from app.text.templates import macros

COLUMNS: Final = 48
"""Columns of a curve; points are in their middles."""

Curve = tuple[float | None, ...]
"""Value of each column, None for a gap; () without a curve."""

WIDTH: Final = 320
HEIGHT: Final = 196
_LEFT: Final = 42
_TOP: Final = 26
_ACROSS: Final = 264
_DOWN: Final = 134
"""Size of the chart and its area [px]."""

_LETTER: Final = 6.7
"""Approximate width of a letter [px]; m and w count twice."""


@dataclass(frozen=True)
class CurveAxis:
    """An axis.

    Attributes:
        factor: from SI to the displayed unit.
        colour: CSS class of the symbol's colour; "" for the text's.
        low, high: ends [SI].
        critical: d_m on an axis of distances.
    """

    symbol: str
    unit: str
    factor: float
    colour: str
    low: float
    high: float
    critical: float | None = None

    @property
    def label(self) -> str:
        return f"{self.symbol} [{self.unit}]" if self.unit else self.symbol

    def fraction(self, value: float) -> float:
        """0 at the lower end, 1 at the upper one."""
        return (value - self.low) / (self.high - self.low)

    def value(self, fraction: float) -> float:
        return self.low + fraction * (self.high - self.low)

    @property
    def ticks(self) -> tuple[tuple[float, str], ...]:
        """Positions and texts of three to six round numbers."""
        low, high = self.low * self.factor, self.high * self.factor
        power = 10.0 ** math.floor(math.log10((high - low) / 5.0))
        step = next(power * s for s in (1.0, 2.0, 2.5, 5.0, 10.0) if power * s >= (high - low) / 5.0 * 0.999)
        numbers = (i * step for i in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1))
        return tuple((self.fraction(n / self.factor), f"{n:.6g}".replace("-", "−")) for n in numbers)


@dataclass(frozen=True)
class Line:
    """A drawn curve.

    Attributes:
        colour: CSS class; "" for the text's colour.
        name: in the legend; "" for no entry.
        width, dash: [px].
    """

    curve: Curve
    colour: str = ""
    name: str = ""
    width: float = 2.0
    dash: str = ""
    opacity: float = 1.0


@lru_cache(maxsize=64)
def curve_chart(x: CurveAxis, y: CurveAxis, lines: tuple[Line, ...], label: str) -> Markup:
    """An <svg> in the page's colours; the first line is at the bottom."""
    strokes = [*_area(x, y), *((line, path_of(line.curve, y)) for line in lines)]
    made, area = macros("plots/curve_chart.html"), (_LEFT, _TOP, _ACROSS, _DOWN)
    return made.chart((WIDTH, HEIGHT), area, COLUMNS, strokes, _texts(x, y), _legend(lines), label)


def path_of(curve: Curve, axis: CurveAxis) -> str:
    """Path in an area of `COLUMNS` by 1, with gaps; values beyond the axis are clipped."""
    parts: list[str] = []
    before = False
    for column, value in enumerate(curve):
        if value is not None:
            place = f"{column + 0.5:g} {1.0 - min(max(axis.fraction(value), 0.0), 1.0):.3f}"
            # A single column is a dot: a line needs a length.
            parts.append(f"L{place}" if before else f"M{place}h.01")
        before = value is not None
    return "".join(parts)


def _area(x: CurveAxis, y: CurveAxis) -> Iterator[tuple[Line, str]]:
    grid = "".join(f"M{at * COLUMNS:.2f} 0v1" for at, _ in x.ticks) + "".join(
        f"M0 {1.0 - at:.3f}h{COLUMNS}" for at, _ in y.ticks
    )
    yield Line((), "", "", 1.0, "", 0.15), grid
    critical = Line((), "dm", "", 1.5, "2 4")
    if x.critical is not None:
        yield critical, f"M{x.fraction(x.critical) * COLUMNS:.2f} 0v1"
    if y.critical is not None:
        yield critical, f"M0 {1.0 - y.fraction(y.critical):.3f}h{COLUMNS}"


class _Text(NamedTuple):
    """Text at a place [px]."""

    words: str
    x: float
    y: float
    anchor: str = ""
    colour: str = ""
    bold: bool = False


_CRITICAL: Final = Markup('{}<tspan dy="3" font-size="11.5">m</tspan>')


def _texts(x: CurveAxis, y: CurveAxis) -> Iterator[_Text]:
    for at, text in x.ticks:
        yield _Text(decimal(text), _LEFT + at * _ACROSS, _TOP + _DOWN + 15, "middle")
    for at, text in y.ticks:
        yield _Text(decimal(text), _LEFT - 6, _TOP + (1.0 - at) * _DOWN + 4, "end")
    yield _Text(x.label, _LEFT + _ACROSS, _TOP + _DOWN + 29, "end", x.colour, True)
    yield _Text(y.label, 4, 14, "start", y.colour, True)
    if x.critical is not None:
        critical = _CRITICAL.format(x.symbol)
        yield _Text(critical, _LEFT + x.fraction(x.critical) * _ACROSS + 4, _TOP + _DOWN - 8, "", "dm", True)
    if y.critical is not None:
        critical = _CRITICAL.format(y.symbol)
        yield _Text(critical, _LEFT + 4, _TOP + (1.0 - y.fraction(y.critical)) * _DOWN - 4, "", "dm", True)


def _legend(lines: tuple[Line, ...]) -> Iterator[tuple[_Text, Line, str]]:
    right = float(_LEFT + _ACROSS)
    for line in reversed(lines):
        if line.name:
            text = _Text(line.name, right, 14, "end")
            right -= _LETTER * (len(line.name) + sum(letter in "MWmw" for letter in line.name)) + 26.0
            yield text, line, f"M{right:.0f} 10h20"
            right -= 10.0
