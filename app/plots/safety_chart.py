"""Laws at equal safety: the largest squared error over the smallest distance, a curve a law over its own knob."""

from typing import Final

import numpy as np

from app.i18n.speaking import tr
from app.plots.chart import Chart, ChartAxes
from app.plots.laws_chart import LAW_NAMES, law_class
from app.session.safety_curves import SafetyPoint
from scenes.experiments import EXPERIMENTS
from scenes.law_knobs import KNOBS, LawKnob
from scenes.settings import RunSettings, specs

FAR: Final = 0.3
"""End of the axis of d_min [m]."""

_SPANS: Final = (0.02, 0.04, 0.08, 0.12, 0.2, 0.4, 0.8, 1.6, 3.2, 6.4)
"""Ends that the axis of e² may have."""

_DOTTED: Final = frozenset({"v", "gamma", "kr"})
"""Keys of second knobs."""


def safety_html(curves: dict[LawKnob, tuple[SafetyPoint, ...]], size: float, run: RunSettings, height: int) -> str:
    """Return the chart, and beside it which line is which.

    Args:
        curves: computed so far.
        size: how much of them that is, from 0 to 1.
        run: its law is drawn thick.
        height: [CSS px].
    """
    inside = [p.e2_max for points in curves.values() for p in points if 0.0 <= p.d_min <= 0.8 * FAR]
    span = next((s for s in _SPANS if s >= max(inside, default=0.1)), _SPANS[-1])
    ticks = tuple((i * span / 4.0, f"{i * span / 4.0:g}") for i in range(5))
    chart = Chart(ChartAxes((0.0, FAR), (0.0, span), tuple((d, f"{d:g}") for d in (0.0, 0.1, 0.2, 0.3)), ticks))
    d_m = run.law.critical_distance
    chart.line(np.array([d_m, d_m + 1e-9]), np.array([0.0, span]), "dm", 1.6, "7 5")
    marked: set[str] = set()
    laws = list(dict.fromkeys(knob.law for knob in KNOBS))
    for knob, points in sorted(curves.items(), key=lambda item: item[0].law == run.law.law):
        dash = "7 5" if knob.feed_forward else "2 4" if knob.key in _DOTTED else ""
        ds, e2 = np.array([p.d_min for p in points]), np.array([p.e2_max for p in points])
        chart.line(ds, e2, law_class(knob.law), 3.0 if knob.law == run.law.law else 1.6, dash)
        seen = np.flatnonzero((ds > 0.05 * FAR) & (ds < 0.97 * FAR) & (e2 < 0.97 * span))
        if len(seen) and knob.law not in marked:
            marked.add(knob.law)
            # Where few other numbers are.
            at = int(seen[-1 - laws.index(knob.law) % len(seen)])
            chart.mark(ds[at], e2[at], f"digit {law_class(knob.law)}", str(list(LAW_NAMES).index(knob.law) + 1))
    unit = EXPERIMENTS[run.scene].error_unit
    state = "" if size >= 1.0 else " · " + tr("{share} % computed", share=round(100.0 * size))
    words = tr("largest e² [{unit}] over d<sub>min</sub> [m]; dashed: with w; dotted: the second knob", unit=unit)
    return (
        f'<div class="duet duet-laws">{chart.html(height - 16)}{_legend(run)}</div>'
        f'<div class="duet"><div class="duet-tip">{words}{state}</div></div>'
    )


def _legend(run: RunSettings) -> str:
    rows: list[str] = []
    for i, (law, label) in enumerate(LAW_NAMES.items()):
        symbols = [tr(specs()[k.key].label) for k in KNOBS if k.law == law and not k.feed_forward]
        if symbols:
            thick = law == run.law.law
            name = f"<b>{tr(label)}</b>" if thick else tr(label)
            rows.append(
                f'<li class="{"thick" if thick else ""}"><i class="{law_class(law)}">{i + 1}</i>{name}: {", ".join(symbols)}</li>'
            )
    return f"<ul>{''.join(rows)}</ul>"
