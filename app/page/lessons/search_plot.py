"""The tries at a challenge that asks for the value of a setting: what came of each, over the value."""

from typing import Final

from app.i18n.speaking import tr
from app.lessons.labels import label_of
from app.lessons.lesson import Challenge, Criterion
from app.lessons.measures.quantity import QUANTITIES, UNITS
from app.lessons.progress import Try
from app.settings import Language
from app.text.html_element import element
from scenes.settings import specs

WIDTH: Final = 300.0
LEFT: Final = 44.0
RIGHT: Final = 290.0
TOP: Final = 24.0
BOTTOM: Final = 132.0
"""Edges of the plot [px]."""

MARGIN: Final = 0.12
"""Of the axes beyond what has to be shown, as a share of it."""


def search_plot(challenge: Challenge, tries: tuple[Try, ...], language: Language) -> str:
    """Return the plot as HTML: a dot for a try that met the first inequality, a cross for one that missed it, the newest one ringed.

    Dashed lines are the bounds of that inequality, and of the setting itself where it has any.
    """
    criterion, spec = challenge.criteria[0], specs()[challenge.search]
    m = criterion.measurement
    factor, sign = UNITS[QUANTITIES[m.name].unit, m.unit]
    k = spec.page_scale
    x_bounds = [bound * k for c in challenge.criteria if _about(c, challenge.search) for bound in _bounds(c)]
    y_bounds = [bound * factor for bound in _bounds(criterion)]
    places = [(one.setting * k, one.measured * factor) for one in tries]
    x, y = PlotAxis([p[0] for p in places] + x_bounds, LEFT, RIGHT), PlotAxis([p[1] for p in places] + y_bounds, BOTTOM, TOP)
    parts = [f'<path class="grid" d="M{LEFT} {TOP}V{BOTTOM}H{RIGHT}"/>']
    parts += [f'<path class="bound" d="M{LEFT} {y.at(bound):.1f}H{RIGHT}"/>' for bound in y_bounds]
    parts += [f'<path class="bound" d="M{x.at(bound):.1f} {BOTTOM}V{TOP}"/>' for bound in x_bounds]
    for place, one in zip(places, tries, strict=True):
        cx, cy = x.at(place[0]), y.at(place[1])
        cross = f'<path class="missed" d="M{cx - 4:.1f} {cy - 4:.1f}l8 8m0 -8l-8 8"/>'
        parts.append(f'<circle class="met" cx="{cx:.1f}" cy="{cy:.1f}" r="4.5"/>' if one.met else cross)
    parts.append(f'<circle class="newest" cx="{x.at(places[-1][0]):.1f}" cy="{y.at(places[-1][1]):.1f}" r="8"/>')
    ends = sorted({p[0] for p in places} | set(x_bounds))
    parts += [_text(f"{v:.3g}", x.at(v), BOTTOM + 14, "middle") for v in (ends[0], ends[-1])]
    levels = sorted({p[1] for p in places} | set(y_bounds))
    parts += [_text(f"{v:.2g}".replace("-", "−"), LEFT - 5, y.at(v) + 4, "end") for v in (levels[0], levels[-1])]
    unit = f" [{spec.page_unit}]" if spec.page_unit else ""
    parts.append(_text(f"{tr(spec.label)}{unit}", (LEFT + RIGHT) / 2.0, BOTTOM + 26, "middle"))
    parts.append(_text(f"{label_of(m, language)} [{sign}]" if sign else label_of(m, language), 2.0, 12.0, "start"))
    name = tr("Your tries: {count}", count=len(tries))
    box = f"0 0 {WIDTH:g} {BOTTOM + 32:g}"
    picture = element("svg", "", *parts, class_="picture search", viewBox=box, role="img", aria_label=name)
    return f"<p><b>{name}</b></p>{picture}"


class PlotAxis:
    """Maps numbers to pixels.

    Args:
        values: that have to be shown.
        low, high: edges [px].
    """

    def __init__(self, values: list[float], low: float, high: float) -> None:
        self._low, first, last = low, min(values), max(values)
        span = (last - first) or abs(first) or 1.0
        self._first = first - MARGIN * span
        self._scale = (high - low) / (span * (1.0 + 2.0 * MARGIN))

    def at(self, value: float) -> float:
        return self._low + (value - self._first) * self._scale


def _about(criterion: Criterion, key: str) -> bool:
    return criterion.measurement.name == "setting" and dict(criterion.measurement.parameters)["key"] == key


def _bounds(criterion: Criterion) -> list[float]:
    return [bound for bound in (criterion.low, criterion.high) if bound is not None]


def _text(text: str, x: float, y: float, anchor: str) -> str:
    return element("text", text, x=f"{x:.1f}", y=f"{y:.1f}", text_anchor=anchor)
