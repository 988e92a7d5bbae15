"""Charts of laws over the distance."""

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from types import MappingProxyType
from typing import Final

import numpy as np
from markupsafe import Markup

from app.i18n.speaking import decimal
from app.plots.chart import Chart, ChartAxes
from app.session.frame import Contact
from app.text.first_task_texts import in_symbols
from app.text.law_texts import LAW_TEXTS, LawLine
from app.text.templates import macros
from controllers.activation import activation
from controllers.laws.situation import Law
from scenes.history import Sample
from scenes.law_answers import LawOfFile
from scenes.laws import LAWS
from scenes.settings import LawSettings
from scenes.simulation import Simulation

FAR: Final = 0.6
"""End of the distance axis [unit of the first task]."""

DISTANCES: Final = tuple((d / 10.0, "" if d % 2 else f"{d / 10.0:g}") for d in range(7))

ORDERS: Final = {1.0: 0.54, 2.0: 0.32, 10.0: 0.1}
"""Order in the paper's Fig. 2 → activation at its name, so that names do not overlap."""

FRAME: Final = ChartAxes((0.0, FAR), (0.0, 1.05), DISTANCES, ((0.0, "0"), (0.5, "0.5"), (1.0, "1")))


def distances(settings: LawSettings, far: float = FAR) -> np.ndarray:
    """Distances (k,) up to `far` [m], finer above d_m and the influence distance, with both sides of both."""
    parts = [np.linspace(0.0, far, 49)]
    for kink in (settings.critical_distance, settings.influence_distance):
        parts.append(np.array([kink - 1e-6, kink]))
        parts.append(kink + 1e-6 + max(far - kink, 0.0) * np.linspace(0.0, 1.0, 25) ** 2)
    points = np.unique(np.concatenate(parts))
    return points[(points >= 0.0) & (points <= far)]


def curve_html(simulation: Simulation, ghost: Simulation | None, sample: Sample, height: int) -> Markup:
    """Chart of λ(d) as in Fig. 2, the ghost's dashed. `height`: [CSS px]."""
    law = simulation.settings.law
    chart = Chart(FRAME)
    xs = distances(law)
    for order in ORDERS:
        ys = np.array([activation(d, law.critical_distance, order) for d in xs.tolist()])
        chart.line(xs, ys, "faint", 1.2)
    for order, level in ORDERS.items():
        chart.mark(law.critical_distance * level ** (-1.0 / order), level, "name faint", f"n = {order:g}")
    if ghost is not None:
        ghost_xs = distances(ghost.settings.law)
        chart.line(ghost_xs, _activations(ghost.law, ghost_xs), "ghost", 2.0, "6 4")
    chart.line(xs, _activations(simulation.law, xs), "lam", 2.6)
    if math.isfinite(sample.law_distance):
        chart.mark(sample.law_distance, sample.activation, "dot lam")
    return chart.html(height)


def _activations(law: Law, xs: np.ndarray) -> np.ndarray:
    return (
        law.activations(xs)
        if isinstance(law, LawOfFile)
        else np.array([law.activation(d) for d in xs.tolist()])
    )


_SPANS: Final = (0.2, 0.4, 0.6, 0.8, 1.2, 1.6, 2.4)
"""Possible ends of the speed axis [m/s]: few, to avoid jitter with u."""


@lru_cache(maxsize=16)
def all_laws(settings: LawSettings) -> dict[str, Law]:
    return {name: replace(settings, law=name).made() for name in LAWS}


DASHES: Final = ("2 4", "12 4 2 4", "")


def laws_html(
    simulation: Simulation,
    ghost: Simulation | None,
    now: Contact,
    height: int,
    ticked: Mapping[str, int] = MappingProxyType({}),
) -> Markup:
    """Chart of a few laws from 0 to 2 d_m, with their numbers: the running law thick, the ghost's dashed.

    Args:
        now: the present state.
        height: [CSS px].
        ticked: further laws → their places in `DASHES`.
    """
    settings = simulation.settings.law
    far = 2.0 * settings.critical_distance
    largest = max(abs(now.pull), settings.nominal_velocity, abs(now.approach), 0.08) * 1.3
    span = next((s for s in _SPANS if s >= largest), _SPANS[-1])
    step = span / 2.0
    ticks = tuple((i * step, f"{i * step:+.1f}".replace("-", "−") if i else "0") for i in (-2, -1, 0, 1, 2))
    x_ticks = tuple((i * far / 4.0, "" if i % 2 else f"{i * far / 4.0:g}") for i in range(5))
    chart = Chart(ChartAxes((0.0, far), (-span, span), x_ticks, ticks))
    chart.level(0.0, "zero", 1.2)
    numbers: list[tuple[float, float, str, str]] = []

    def draw(name: str, law: Law, of: LawSettings, width: float, dash: str = "") -> None:
        xs = distances(of, far)
        ys = _rates(law, xs, now)
        chart.line(xs, ys, law_class(name), width, dash)
        if not isinstance(law, LawOfFile):
            x = min(max(LAW_TEXTS[name].anchor(of, LawLine(xs, ys, span)), 0.06 * far), 0.94 * far)
            numbers.append(
                (x, float(np.interp(x, xs, ys)), f"digit {law_class(name)}", str(list(LAWS).index(name) + 1))
            )

    running, laws = settings.law, all_laws(settings)
    for name, place in ticked.items():
        if name != running or isinstance(simulation.law, LawOfFile):
            draw(name, laws[name], settings, 1.9, DASHES[place])
    if ghost is not None:
        draw(ghost.settings.law.law, ghost.law, ghost.settings.law, 3.0, "7 5")
    draw(running, simulation.law, settings, 3.2)
    if abs(now.approach) > 0.005:
        chart.level(now.approach, "w", 1.2, "2 4")
        chart.mark(0.0, now.approach, "name w", "w")
    for number in numbers:
        chart.mark(*number)
    if now.distance <= far:
        chart.mark(now.distance, now.rate, f"dot {law_class(running)}")
    u, lever = (
        decimal(f"{value:.2f}".replace("-", "−")) for value in (now.pull + 0.0, math.sqrt(now.square))
    )
    quantity = simulation.settings.quantity
    row = in_symbols(Markup("J<sub>d</sub>"), quantity)
    return macros("plots/charts.html").laws(chart.html(height), u, row, lever, quantity.row_unit)


def _rates(law: Law, xs: np.ndarray, now: Contact) -> np.ndarray:
    if isinstance(law, LawOfFile):
        return law.line_rates(xs, now.pull, now.approach, now.square)
    return np.array([law.line_rate(d, now.pull, now.approach, now.square) for d in xs.tolist()])


def law_class(name: str) -> str:
    return f"law{list(LAWS).index(name) + 1}"


def laws_legend(simulation: Simulation) -> tuple[tuple[str, str, str], ...]:
    """Class, kind and name of a custom law's line; other lines have a number."""
    return (
        ((law_class(simulation.settings.law.law), "", simulation.law.file),)
        if isinstance(simulation.law, LawOfFile)
        else ()
    )
