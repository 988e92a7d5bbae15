"""A chart of all laws: the rate that each gives at the present pull, over the distance."""

import math
from dataclasses import replace
from functools import lru_cache
from typing import Final, cast

import numpy as np

from app.custom_law.custom_law import CustomLaw
from app.i18n.speaking import tr
from app.plots.activation_curve import DISTANCES, FAR, distances
from app.plots.chart import Chart, ChartAxes
from app.session.contact import Contact
from controllers.laws.situation import Law
from scenes.law_factory import make_law
from scenes.settings import LawName, LawSettings
from scenes.simulation import Simulation

LAW_NAMES: Final[dict[LawName, str]] = {
    "smooth_priority": "Smooth priority",
    "strict_priority": "Strict, always on",
    "strict_switched": "Strict, switched",
    "null_space_avoidance": "Null-space avoidance",
    "potential_field": "Potential field",
    "barrier_qp": "Barrier QP",
    "intermediate_value": "Intermediate value",
    "task_activation": "Task activation",
    "continuous_inverse": "Continuous inverse",
    "set_based_task": "Set-based task",
    "unprotected": "Unprotected",
}
"""Short names, in the order of the picker."""

_SPANS: Final = (0.2, 0.4, 0.6, 0.8, 1.2, 1.6, 2.4)
"""Ends that the axis of speeds may have [m/s]: few, so that it does not breathe with u."""


@lru_cache(maxsize=16)
def all_laws(settings: LawSettings) -> dict[LawName, Law]:
    return {name: make_law(replace(settings, law=name)) for name in LAW_NAMES}


def laws_html(simulation: Simulation, ghost: Simulation | None, now: Contact, height: int) -> str:
    """Return the chart, and beside it which line is which.

    Args:
        simulation: its law is drawn thick.
        ghost: its law is drawn dashed; None for no ghost.
        now: pull, approach and |J_d|² that all laws are asked with, and the present state.
        height: [CSS px].
    """
    settings = simulation.settings.law
    largest = max(abs(now.pull), settings.nominal_velocity, abs(now.approach), 0.08) * 1.3
    span = next((s for s in _SPANS if s >= largest), _SPANS[-1])
    step = span / 2.0
    ticks = tuple((i * step, f"{i * step:+.1f}".replace("-", "−") if i else "0") for i in (-2, -1, 0, 1, 2))
    chart = Chart(ChartAxes((0.0, FAR), (-span, span), DISTANCES, ticks))
    chart.level(0.0, "zero", 1.2)
    xs = distances(settings.critical_distance, settings.influence_distance)
    lines: dict[LawName, np.ndarray] = {name: _rates(law, xs, now) for name, law in all_laws(settings).items()}
    present = settings.law
    for name, ys in lines.items():
        if name != present:
            chart.line(xs, ys, law_class(name), 1.5)
    if ghost is not None:
        other = ghost.settings.law
        ghost_xs = distances(other.critical_distance, other.influence_distance)
        chart.line(ghost_xs, _rates(ghost.law, ghost_xs, now), law_class(other.law), 3.0, "7 5")
    chart.line(xs, lines[present], law_class(present), 3.2)
    if abs(now.approach) > 0.005:
        chart.level(now.approach, "w", 1.2, "2 4")
        chart.mark(0.0, now.approach, "name w", "w")
    for i, (name, ys) in enumerate(lines.items()):
        x, y = _anchor(name, settings, xs, ys, span)
        chart.mark(x, y, f"digit {law_class(name)}", str(i + 1))
    if math.isfinite(now.distance):
        chart.mark(now.distance, now.rate, f"dot {law_class(present)}")
    return f'<div class="duet duet-laws">{chart.html(height)}{_legend(present, ghost, now)}</div>'


def _rates(law: Law, xs: np.ndarray, now: Contact) -> np.ndarray:
    if isinstance(law, CustomLaw):
        return law.line_rates(xs, now.pull, now.approach, now.square)
    return np.array([law.line_rate(d, now.pull, now.approach, now.square) for d in xs.tolist()])


def _anchor(name: LawName, settings: LawSettings, xs: np.ndarray, ys: np.ndarray, span: float) -> tuple[float, float]:
    """Return where a line gets its number: where few other lines are near."""
    d_m = settings.critical_distance
    at = {
        "smooth_priority": d_m * 0.72 ** (-1.0 / settings.order),
        "strict_priority": 0.92 * FAR,
        "null_space_avoidance": d_m + 0.6 * max(settings.influence_distance - d_m, 0.0),
        "barrier_qp": max(d_m - 0.25 * span / settings.barrier_gain, 0.03),
        "intermediate_value": d_m * 0.24 ** (-1.0 / settings.order),
        "task_activation": d_m + 0.3 * max(settings.influence_distance - d_m, 0.0),
        "continuous_inverse": d_m * 0.45 ** (-1.0 / settings.order),
        "set_based_task": max(d_m - 0.6 * span / max(settings.restoring_gain, 1.0), 0.02),
        "unprotected": 0.35 * d_m,
    }
    if name == "strict_switched":
        # On its jump, nearer to the lower end.
        i = int(np.searchsorted(xs, d_m + 5e-7))
        return d_m, 0.35 * float(ys[i - 1]) + 0.65 * float(ys[min(i, len(ys) - 1)])
    if name == "potential_field":
        # High on its flank, where the others are not.
        high = 0.72 * span
        below = int(np.argmax(ys < high))
        if below and ys[below - 1] > ys[below]:
            share = float((ys[below - 1] - high) / (ys[below - 1] - ys[below]))
            return float(xs[below - 1] + share * (xs[below] - xs[below - 1])), high
        x = 0.08
    else:
        x = at[name]
    return x, float(np.interp(x, xs, ys))


def law_class(name: str) -> str:
    """Return the class of CSS that gives a law its colour."""
    return f"law{list(LAW_NAMES).index(cast(LawName, name)) + 1}"


def _legend(present: str, ghost: Simulation | None, now: Contact) -> str:
    rows: list[str] = []
    for i, (name, label) in enumerate(LAW_NAMES.items()):
        shown = f"<b>{tr(label)}</b>" if name == present else tr(label)
        rows.append(f'<li class="{"thick" if name == present else ""}"><i class="{law_class(name)}">{i + 1}</i>{shown}</li>')
    if ghost is not None:
        rows.append(f'<li class="ghost"><i class="{law_class(ghost.settings.law.law)} dash"></i>{tr("the ghost’s")}</li>')
    numbers = f'<b class="u">u</b> {now.pull + 0.0:.2f}, |J<sub>d</sub>| {math.sqrt(now.square):.2f} m/rad'.replace("-", "−")
    return f"<ul>{''.join(rows)}<li class=now>{numbers}</li></ul>"
