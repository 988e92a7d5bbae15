"""Fig. 2, live: the activation λ over the distance d, with the present state as a dot."""

import math
from typing import Final

import numpy as np

from app.custom_law.custom_law import CustomLaw
from app.plots.chart import Chart, ChartAxes
from controllers.activation import activation
from controllers.laws.situation import Law
from scenes.history import Sample
from scenes.simulation import Simulation

FAR: Final = 0.6
"""End of the axis of distances [m]."""

DISTANCES: Final = tuple((d / 10.0, "" if d % 2 else f"{d / 10.0:g}") for d in range(7))
"""Its ticks, every other one with a number."""

ORDERS: Final = (1.0, 2.0, 10.0)
"""Of the paper's Fig. 2."""

FRAME: Final = ChartAxes((0.0, FAR), (0.0, 1.05), DISTANCES, ((0.0, "0"), (0.5, "0.5"), (1.0, "1")))


def distances(*kinks: float) -> np.ndarray:
    """Return distances (k,) [m] to draw a law at: finer right above every kink, and on either side of it."""
    parts = [np.linspace(0.0, FAR, 49)]
    for kink in kinks:
        parts.append(np.array([kink - 1e-6, kink]))
        parts.append(kink + 1e-6 + (FAR - kink) * np.linspace(0.0, 1.0, 25) ** 2)
    points = np.unique(np.concatenate(parts))
    return points[(points >= 0.0) & (points <= FAR)]


def curve_html(simulation: Simulation, ghost: Simulation | None, sample: Sample, height: int) -> str:
    """Return the chart of λ(d).

    Args:
        simulation: with the law that is drawn.
        ghost: its law is drawn dashed; None for no ghost.
        height: [CSS px].
    """
    law = simulation.settings.law
    chart = Chart(FRAME)
    xs = distances(law.critical_distance, law.influence_distance)
    for order in ORDERS:
        ys = np.array([activation(d, law.critical_distance, order) for d in xs.tolist()])
        chart.line(xs, ys, "faint", 1.2)
    # Each name where its curve is two thirds of the way down, or, for a steep one, at its foot: there they are far from each other.
    for order in ORDERS:
        level = 0.34 if order < 5.0 else 0.1
        chart.mark(law.critical_distance * level ** (-1.0 / order), level, "name faint", f"n = {order:g}")
    if ghost is not None:
        other = ghost.settings.law
        ghost_xs = distances(other.critical_distance, other.influence_distance)
        chart.line(ghost_xs, _activations(ghost.law, ghost_xs), "ghost", 2.0, "6 4")
    chart.line(xs, _activations(simulation.law, xs), "lam", 2.6)
    if math.isfinite(sample.law_distance):
        chart.mark(sample.law_distance, sample.activation, "dot lam")
    return chart.html(height)


def _activations(law: Law, xs: np.ndarray) -> np.ndarray:
    return law.activations(xs) if isinstance(law, CustomLaw) else np.array([law.activation(d) for d in xs.tolist()])
