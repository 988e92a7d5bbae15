"""Axes for drawn curves, and their reader."""

import json
import math
from bisect import insort
from dataclasses import dataclass, replace
from typing import Final, TypeGuard

from markupsafe import Markup

from app.i18n.speaking import N_, tr
from app.plots.curve_chart import COLUMNS, Curve, CurveAxis, Line, curve_chart
from app.text.first_task_texts import over_name
from controllers.curve import curve_text, curve_through
from controllers.errors import NumberText
from scenes.quantities import DISTANCE, KeptQuantity


@dataclass(frozen=True)
class AxisQuantity:
    """A quantity of an axis, see `CurveAxis`.

    Attributes:
        column: of the history; the error is the root of its column.
        digits: decimals in that unit.
    """

    column: str
    symbol: str
    unit: str
    factor: float
    colour: str
    digits: int
    word: str


AXES: Final = {
    "time": AxisQuantity("t", "t", "s", 1.0, "", 1, N_("time")),
    "distance": AxisQuantity("d", "d", "mm", 1000.0, "d", 0, N_("distance d")),
    "activation": AxisQuantity("lambda", "λ", "", 1.0, "lam", 2, "λ"),
    "error": AxisQuantity("e2", "|e|", "mm", 1000.0, "e", 0, N_("hand error |e|")),
    "approach": AxisQuantity("w", "w", "m/s", 1.0, "w", 2, N_("approach w")),
}

UNSEEN: Final = 0.01
"""Difference of λ that is invisible on the board."""

MOST_TEXT: Final = 2000
"""Longest text from a browser [characters]."""


@dataclass(frozen=True)
class Drawing:
    """A drawing's axes, and its comparison.

    Attributes:
        x_name, y_name: keys of `AXES`.
        formula: compare with eq. (31) for the run's settings, not with the recorded run.
        within: largest mean distance from the true curve in a correct drawing [unit of `y`, SI].
        kept: quantity of an axis of distances.
    """

    x_name: str
    y_name: str
    x: CurveAxis
    y: CurveAxis
    formula: bool
    within: float
    kept: KeptQuantity = DISTANCE

    @property
    def columns(self) -> tuple[float, ...]:
        return tuple(self.x.value((i + 0.5) / COLUMNS) for i in range(COLUMNS))

    def text(self, value: float) -> str:
        """Text of a difference along `y`, rounded up: one beyond `within` must not look within it."""
        quantity = AXES[self.y_name]
        power = 10.0**quantity.digits
        return NumberText(
            f"{math.ceil(value * quantity.factor * power - 1e-6) / power:.{quantity.digits}f} {quantity.unit}".rstrip()
        )


def activation_axes(critical: float, ends: tuple[float, float], kept: KeptQuantity = DISTANCE) -> Drawing:
    """Axes for a λ(d) without comparison. `critical`: d_m, `ends`: of the axis of d [unit of `kept`]."""
    x, y = axis_of("distance", ends, critical), axis_of("activation", (0.0, 1.0), critical)
    if kept is not DISTANCE:
        x = replace(x, symbol=kept.symbol, unit=kept.page_unit)
    return Drawing("distance", "activation", x, y, True, 1.0, kept)


def axis_of(name: str, ends: tuple[float, float], d_m: float) -> CurveAxis:
    """Axis of `AXES[name]`. `ends`: SI; `d_m`: marked on an axis of d [m]."""
    quantity, (low, high) = AXES[name], ends
    shows_critical = name == "distance" and low < d_m < high
    return CurveAxis(
        quantity.symbol,
        quantity.unit,
        quantity.factor,
        quantity.colour,
        low,
        high,
        d_m if shows_critical else None,
    )


def _is_number(value: object) -> TypeGuard[int | float]:
    return isinstance(value, int | float) and not isinstance(value, bool)


def curve_from_text(drawing: Drawing, text: object) -> Curve | None:
    """Curve from the browser's JSON list of fractions of the height, null for a gap; None if invalid."""
    if not isinstance(text, str) or len(text) > MOST_TEXT:
        return None
    try:
        heights = json.loads(text)
    except (ValueError, RecursionError):
        return None
    if not isinstance(heights, list) or not all(
        h is None or (_is_number(h) and 0.0 <= h <= 1.0) for h in heights
    ):
        return None
    return checked_curve(drawing, [None if h is None else drawing.y.value(h) for h in heights])


def checked_curve(drawing: Drawing, values: object) -> Curve | None:
    """Values by column as a curve, () if empty; None if they do not fit the axes."""
    if not isinstance(values, (list, tuple)) or len(values) not in (0, COLUMNS):
        return None
    slack, known = 1e-6 * (drawing.y.high - drawing.y.low), [v for v in values if v is not None]
    if not all(_is_number(v) and drawing.y.low - slack <= v <= drawing.y.high + slack for v in known):
        return None
    return tuple(None if v is None else float(v) for v in values) if known else ()


def law_curve(drawing: Drawing, drawn: Curve) -> str:
    """Text of the law that stays within `UNSEEN` of a drawn λ(d)."""
    points = [(d, lam) for d, lam in zip(drawing.columns, drawn, strict=True) if lam is not None]
    if len(points) == 1:
        points.append((drawing.x.high, points[0][1]))
    kept = [points[0], points[-1]]
    while True:
        text = curve_text(tuple(kept))
        curve = curve_through(text)
        # Straight lines between the points would need fewer; the law's curve is level at both ends and at every turn.
        worst = max(points, key=lambda point: abs(point[1] - curve.height(point[0])))
        if abs(worst[1] - curve.height(worst[0])) <= UNSEEN:
            return text
        insort(kept, worst)


def board_svg(drawing: Drawing, drawn: Curve) -> Markup:
    """The axes; `drawing.js` changes the line of the class "pencil"."""
    return curve_chart(drawing.x, drawing.y, (Line(drawn, "pencil", "", 2.4),), axes_text(drawing))


def axes_text(drawing: Drawing) -> str:
    x, y = (
        over_name(drawing.kept) if name == "distance" else tr(AXES[name].word)
        for name in (drawing.x_name, drawing.y_name)
    )
    return tr("{y} over {x}", y=y, x=x)
