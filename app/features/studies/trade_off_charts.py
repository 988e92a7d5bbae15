"""Charts of the trade-off and of equal safety."""

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import Final

import numpy as np
from markupsafe import Markup

from app.features.studies.background_studies import SafetyPoint
from app.features.studies.law_knobs import LawKnob, knobs
from app.i18n.speaking import tr
from app.plots.chart import Chart, ChartAxes
from app.plots.law_charts import law_class
from app.text.first_task_texts import in_symbols
from app.text.templates import macros, tr_html
from scenes.laws import LAWS
from scenes.settings import RunSettings, specs
from scenes.sweep import TRADE_OFF_ORDERS, TRADE_OFF_VELOCITIES, TradeOff

_TICKS: Final = tuple((value, f"{value:g}") for value in (0.0, 0.1, 0.2, 0.3, 0.4))
FRAME: Final = ChartAxes((0.0, 0.4), (0.0, 0.4), _TICKS, _TICKS)
"""d_min over the largest |e| [m]."""


def map_html(points: tuple[TradeOff, ...], size: float, run: RunSettings, height: int) -> Markup:
    """Map of the trade-off. `size`: finished share, 0 to 1. `height`: [CSS px]."""
    chart = Chart(FRAME)
    d_m = run.law.critical_distance
    chart.line(np.array([d_m, d_m + 1e-9]), np.array([0.0, FRAME.y[1]]), "dm", 1.6, "7 5")
    for order in TRADE_OFF_ORDERS:
        row = sorted((p for p in points if p.order == order), key=lambda p: p.nominal_velocity)
        for before, after in pairwise(row):
            ends = sorted((before, after), key=lambda p: p.d_min)
            chart.line(
                np.array([p.d_min for p in ends]), np.array([p.e2_max**0.5 for p in ends]), "faint", 1.2
            )
        if row:
            last = row[-1]
            chart.mark(last.d_min, last.e2_max**0.5, "name faint", f"n = {order:g}")
    here = place_on_map(points, run)
    if here is not None:
        chart.mark(*here, "dot lam")
    low, high = TRADE_OFF_VELOCITIES[0], TRADE_OFF_VELOCITIES[-1]
    words = tr_html(
        "largest |e| [m] over d<sub>min</sub> [m]; a line an n, along it v from {low} to {high} m/s",
        low=f"{low:g}",
        high=f"{high:g}",
    )
    return macros("plots/charts.html").below(chart.html(height - 16), words, size)


def place_on_map(points: tuple[TradeOff, ...], run: RunSettings) -> tuple[float, float] | None:
    """d_min and largest |e| [m] of the current n and v; None while the map is incomplete."""
    if len(points) < len(TRADE_OFF_ORDERS) * len(TRADE_OFF_VELOCITIES):
        return None
    table = {(p.order, p.nominal_velocity): (p.d_min, p.e2_max**0.5) for p in points}
    field = np.array([[table[n, v] for v in TRADE_OFF_VELOCITIES] for n in TRADE_OFF_ORDERS])
    log_n, log_v = (math.log(max(value, 1e-6)) for value in (run.law.order, run.law.nominal_velocity))
    # Beyond the map's edge, use the values at the edge.
    columns = [
        [np.interp(log_v, np.log(TRADE_OFF_VELOCITIES), row) for row in field[:, :, i]] for i in range(2)
    ]
    d, e = (float(np.interp(log_n, np.log(TRADE_OFF_ORDERS), column)) for column in columns)
    return d, e


FAR: Final = 0.3
"""End of the d_min axis, in the first task's unit."""

_SPANS: Final = (0.02, 0.04, 0.08, 0.12, 0.2, 0.4, 0.8, 1.6, 3.2, 6.4)


def safety_html(
    curves: dict[LawKnob, tuple[SafetyPoint, ...]], size: float, run: RunSettings, height: int
) -> Markup:
    """Chart of the laws, with a legend. `size`, `height`: see `map_html`."""
    inside = [p.e2_max for points in curves.values() for p in points if 0.0 <= p.d_min <= 0.8 * FAR]
    span = next((s for s in _SPANS if s >= max(inside, default=0.1)), _SPANS[-1])
    ticks = tuple((i * span / 4.0, f"{i * span / 4.0:g}") for i in range(5))
    chart = Chart(
        ChartAxes((0.0, FAR), (0.0, span), tuple((d, f"{d:g}") for d in (0.0, 0.1, 0.2, 0.3)), ticks)
    )
    d_m = run.law.critical_distance
    chart.line(np.array([d_m, d_m + 1e-9]), np.array([0.0, span]), "dm", 1.6, "7 5")
    marked: set[str] = set()
    laws = list(dict.fromkeys(knob.law for knob in knobs()))
    for knob, points in sorted(curves.items(), key=lambda item: item[0].law == run.law.law):
        dash = "7 5" if knob.setting.feed_forward else "2 4" if knob.second else ""
        ds, e2 = np.array([p.d_min for p in points]), np.array([p.e2_max for p in points])
        chart.line(ds, e2, law_class(knob.law), 3.0 if knob.law == run.law.law else 1.6, dash)
        seen = np.flatnonzero((ds > 0.05 * FAR) & (ds < 0.97 * FAR) & (e2 < 0.97 * span))
        if len(seen) and knob.law not in marked:
            marked.add(knob.law)
            # A place with few other numbers.
            at = int(seen[-1 - laws.index(knob.law) % len(seen)])
            chart.mark(ds[at], e2[at], f"digit {law_class(knob.law)}", str(list(LAWS).index(knob.law) + 1))
    unit = run.experiment.error_unit
    words = tr_html(
        "largest e² [{unit}] over d<sub>min</sub> [m]; dashed: with w; dotted: the second knob", unit=unit
    )
    words = in_symbols(words, run.quantity)
    return macros("plots/charts.html").safety(chart.html(height - 16), list(_legend(run)), words, size)


def _legend(run: RunSettings) -> Iterator[tuple[str, int, str, str, list[str]]]:
    for i, (name, law) in enumerate(LAWS.items(), 1):
        symbols = [
            in_symbols(tr(specs()[knob.key].label), run.quantity)
            for knob in law.knobs
            if not knob.feed_forward
        ]
        if symbols:
            yield "thick" if name == run.law.law else "", i, law_class(name), tr(law.short), symbols
