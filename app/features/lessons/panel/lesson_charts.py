"""Charts of a search's tries, and of two runs."""

from collections.abc import Callable
from typing import Final

import numpy as np
from markupsafe import Markup

from app.features.lessons.labels import label_of
from app.features.lessons.lesson import Challenge, Criterion
from app.features.lessons.progress import Try
from app.features.measures.quantities.quantity import UNITS
from app.i18n.speaking import decimal, tr
from app.plots.chart import Chart, ChartAxes
from app.settings import Language
from app.text.first_task_texts import in_symbols
from app.text.templates import element, macros
from controllers.kinematics import Array
from scenes.history import COLUMN
from scenes.settings import specs
from scenes.simulation import Simulation

WIDTH: Final = 300.0
LEFT: Final = 44.0
RIGHT: Final = 290.0
TOP: Final = 24.0
BOTTOM: Final = 132.0
"""Edges of the plot [px]."""

MARGIN: Final = 0.12


def search_plot(challenge: Challenge, tries: tuple[Try, ...], language: Language) -> Markup:
    """Plot of the tries: dots met the first criterion, crosses missed it; dashed lines are bounds."""
    criterion, spec = challenge.criteria[0], specs()[challenge.search]
    m = criterion.measurement
    _, factor, sign = UNITS[m.unit]
    k = spec.page_scale
    x_bounds = [bound * k for c in challenge.criteria if _about(c, challenge.search) for bound in _bounds(c)]
    y_bounds = [bound * factor for bound in _bounds(criterion)]
    places = [(one.setting * k, one.measured * factor) for one in tries]
    x, y = (
        _axis([p[0] for p in places] + x_bounds, LEFT, RIGHT),
        _axis([p[1] for p in places] + y_bounds, BOTTOM, TOP),
    )
    lines = [
        ("grid", f"M{LEFT} {TOP}V{BOTTOM}H{RIGHT}"),
        *(("bound", f"M{LEFT} {y(bound):.1f}H{RIGHT}") for bound in y_bounds),
        *(("bound", f"M{x(bound):.1f} {BOTTOM}V{TOP}") for bound in x_bounds),
    ]
    dots = [(x(place[0]), y(place[1]), one.met) for place, one in zip(places, tries, strict=True)]
    ends, levels = (
        sorted({p[0] for p in places} | set(x_bounds)),
        sorted({p[1] for p in places} | set(y_bounds)),
    )
    unit = f" [{spec.page_unit}]" if spec.page_unit else ""
    texts = [
        *((decimal(f"{v:.3g}"), x(v), BOTTOM + 14, "middle") for v in (ends[0], ends[-1])),
        *(
            (decimal(f"{v:.2g}".replace("-", "−")), LEFT - 5, y(v) + 4, "end")
            for v in (levels[0], levels[-1])
        ),
        (f"{tr(spec.label)}{unit}", (LEFT + RIGHT) / 2.0, BOTTOM + 26, "middle"),
        (f"{label_of(m, language)} [{sign}]" if sign else label_of(m, language), 2.0, 12.0, "start"),
    ]
    name, box = tr("Your tries: {count}", count=len(tries)), f"0 0 {WIDTH:g} {BOTTOM + 32:g}"
    return macros("features/lessons/panel/search_plot.html").plot(name, box, lines, dots, texts)


def _axis(values: list[float], low: float, high: float) -> Callable[[float], float]:
    first, last = min(values), max(values)
    span = (last - first) or abs(first) or 1.0
    begin, scale = first - MARGIN * span, (high - low) / (span * (1.0 + 2.0 * MARGIN))
    return lambda value: low + (value - begin) * scale


def _about(criterion: Criterion, key: str) -> bool:
    return criterion.measurement.name == "setting" and dict(criterion.measurement.parameters)["key"] == key


def _bounds(criterion: Criterion) -> list[float]:
    return [bound for bound in (criterion.low, criterion.high) if bound is not None]


TRACK_POINTS: Final = 240
"""Parts of a run; each shows its smallest distance."""


def tracks_html(own: Simulation, rival: Simulation, names: tuple[str, str]) -> Markup:
    end, critical = own.time, own.settings.law.critical_distance
    tracks = [_track(run.history.table()) for run in (own, rival)]
    low, high = min(-0.05, *(float(ys.min()) for _, ys in tracks)), max(float(ys.max()) for _, ys in tracks)
    levels = [
        (k / 10.0, f"{100 * k}".replace("-", "−"))
        for k in range(int(np.ceil(10.0 * low)), int(10.0 * high) + 1)
    ]
    times = [(t, decimal(f"{t:.3g}") + (" s" if t == end else "")) for t in np.linspace(0.0, end, 5).tolist()]
    chart = Chart(ChartAxes((0.0, end), (low, 1.05 * high), tuple(times), tuple(levels)))
    chart.level(critical, "dm", 1.6, "7 5")
    for (xs, ys), kind, dash in zip(tracks, ("lam", "d"), ("", "5 3"), strict=True):
        chart.line(xs, ys, kind, 1.8, dash)
    kept = own.settings.quantity
    threshold = in_symbols(Markup("d<sub>m</sub>"), kept)
    lines = [("lam", "", names[0]), ("d", "dash", names[1]), ("dm", "dash", threshold)]
    title = in_symbols(Markup('<b class="d">d</b>'), kept)
    made = macros("plots/charts.html").caption(title, kept.page_unit, lines, False, False) + chart.html(150)
    return element("div", "", made, class_="duet duet-lesson duet-l-tracks")


def _track(table: Array) -> tuple[Array, Array]:
    parts = np.array_split(table[:, [COLUMN["t"], COLUMN["d"]]], min(TRACK_POINTS, len(table)))
    lowest = np.array([part[part[:, 1].argmin()] for part in parts])
    return lowest[:, 0], lowest[:, 1]
