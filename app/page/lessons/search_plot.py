"""The tries at a challenge that asks for the value of a setting: what came of each, over the value."""

from collections.abc import Callable
from typing import Final

from markupsafe import Markup

from app.i18n.speaking import decimal, tr
from app.lessons.labels import label_of
from app.lessons.lesson import Challenge, Criterion
from app.lessons.measures.quantity import UNITS
from app.lessons.progress import Try
from app.settings import Language
from app.text.templates import macros
from scenes.settings import specs

WIDTH: Final = 300.0
LEFT: Final = 44.0
RIGHT: Final = 290.0
TOP: Final = 24.0
BOTTOM: Final = 132.0
"""Edges of the plot [px]."""

MARGIN: Final = 0.12
"""Of the axes beyond what has to be shown, as a share of it."""


def search_plot(challenge: Challenge, tries: tuple[Try, ...], language: Language) -> Markup:
    """Return the plot as HTML: a dot for a try that met the first inequality, a cross for one that missed it, the newest one ringed.

    Dashed lines are the bounds of that inequality, and of the setting itself where it has any.
    """
    criterion, spec = challenge.criteria[0], specs()[challenge.search]
    m = criterion.measurement
    _, factor, sign = UNITS[m.unit]
    k = spec.page_scale
    x_bounds = [bound * k for c in challenge.criteria if _about(c, challenge.search) for bound in _bounds(c)]
    y_bounds = [bound * factor for bound in _bounds(criterion)]
    places = [(one.setting * k, one.measured * factor) for one in tries]
    x, y = _axis([p[0] for p in places] + x_bounds, LEFT, RIGHT), _axis([p[1] for p in places] + y_bounds, BOTTOM, TOP)
    lines = [
        ("grid", f"M{LEFT} {TOP}V{BOTTOM}H{RIGHT}"),
        *(("bound", f"M{LEFT} {y(bound):.1f}H{RIGHT}") for bound in y_bounds),
        *(("bound", f"M{x(bound):.1f} {BOTTOM}V{TOP}") for bound in x_bounds),
    ]
    dots = [(x(place[0]), y(place[1]), one.met) for place, one in zip(places, tries, strict=True)]
    ends, levels = sorted({p[0] for p in places} | set(x_bounds)), sorted({p[1] for p in places} | set(y_bounds))
    unit = f" [{spec.page_unit}]" if spec.page_unit else ""
    texts = [
        *((decimal(f"{v:.3g}"), x(v), BOTTOM + 14, "middle") for v in (ends[0], ends[-1])),
        *((decimal(f"{v:.2g}".replace("-", "−")), LEFT - 5, y(v) + 4, "end") for v in (levels[0], levels[-1])),
        (f"{tr(spec.label)}{unit}", (LEFT + RIGHT) / 2.0, BOTTOM + 26, "middle"),
        (f"{label_of(m, language)} [{sign}]" if sign else label_of(m, language), 2.0, 12.0, "start"),
    ]
    name, box = tr("Your tries: {count}", count=len(tries)), f"0 0 {WIDTH:g} {BOTTOM + 32:g}"
    return macros("page/lessons/search_plot.html").plot(name, box, lines, dots, texts)


def _axis(values: list[float], low: float, high: float) -> Callable[[float], float]:
    """Return the map from numbers to pixels that shows all `values`. `low`, `high`: edges [px]."""
    first, last = min(values), max(values)
    span = (last - first) or abs(first) or 1.0
    begin, scale = first - MARGIN * span, (high - low) / (span * (1.0 + 2.0 * MARGIN))
    return lambda value: low + (value - begin) * scale


def _about(criterion: Criterion, key: str) -> bool:
    return criterion.measurement.name == "setting" and dict(criterion.measurement.parameters)["key"] == key


def _bounds(criterion: Criterion) -> list[float]:
    return [bound for bound in (criterion.low, criterion.high) if bound is not None]
