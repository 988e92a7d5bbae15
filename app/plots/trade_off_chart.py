"""The trade-off of n and v: how near the arms come against how far the hand gives way, a dot a run, and the present settings among them."""

from itertools import pairwise
from typing import Final

import numpy as np

from app.i18n.speaking import tr
from app.plots.chart import Chart, ChartAxes
from scenes.settings import RunSettings
from scenes.sweep import TRADE_OFF_ORDERS, TRADE_OFF_VELOCITIES, TradeOff

_TICKS: Final = tuple((value, f"{value:g}") for value in (0.0, 0.1, 0.2, 0.3, 0.4))
FRAME: Final = ChartAxes((0.0, 0.4), (0.0, 0.4), _TICKS, _TICKS)
"""d_min over the largest |e|, both in m."""


def map_html(points: tuple[TradeOff, ...], size: float, run: RunSettings, height: int) -> str:
    """Return the map.

    Args:
        points: computed so far.
        size: how much of the map that is, from 0 to 1.
        run: its n and v are marked.
        height: [CSS px].
    """
    chart = Chart(FRAME)
    d_m = run.law.critical_distance
    chart.line(np.array([d_m, d_m + 1e-9]), np.array([0.0, FRAME.y[1]]), "dm", 1.6, "7 5")
    for order in TRADE_OFF_ORDERS:
        row = sorted((p for p in points if p.order == order), key=lambda p: p.nominal_velocity)
        for before, after in pairwise(row):
            ends = sorted((before, after), key=lambda p: p.d_min)
            chart.line(np.array([p.d_min for p in ends]), np.array([p.e2_max**0.5 for p in ends]), "faint", 1.2)
        if row:
            last = row[-1]
            chart.mark(last.d_min, last.e2_max**0.5, "name faint", f"n = {order:g}")
    here = place_of(points, run)
    if here is not None:
        chart.mark(*here, "dot lam")
    state = "" if size >= 1.0 else " · " + tr("{share} % computed", share=round(100.0 * size))
    low, high = TRADE_OFF_VELOCITIES[0], TRADE_OFF_VELOCITIES[-1]
    words = tr(
        "largest |e| [m] over d<sub>min</sub> [m]; a line an n, along it v from {low} to {high} m/s",
        low=f"{low:g}",
        high=f"{high:g}",
    )
    return f'<div class="duet">{chart.html(height - 16)}<div class="duet-tip">{words}{state}</div></div>'


def place_of(points: tuple[TradeOff, ...], run: RunSettings) -> tuple[float, float] | None:
    """Return d_min and the largest |e| [m] of the present n and v, between the points of the map; None while it is not complete."""
    if len(points) < len(TRADE_OFF_ORDERS) * len(TRADE_OFF_VELOCITIES):
        return None
    table = {(p.order, p.nominal_velocity): np.array([p.d_min, p.e2_max**0.5]) for p in points}
    (n0, n1, s), (v0, v1, t) = (
        _between(np.log(np.array(values)), float(np.log(max(value, 1e-6))), values)
        for values, value in ((TRADE_OFF_ORDERS, run.law.order), (TRADE_OFF_VELOCITIES, run.law.nominal_velocity))
    )
    low = (1.0 - t) * table[n0, v0] + t * table[n0, v1]
    high = (1.0 - t) * table[n1, v0] + t * table[n1, v1]
    d, e = ((1.0 - s) * low + s * high).tolist()
    return d, e


def _between(logs: np.ndarray, log: float, values: tuple[float, ...]) -> tuple[float, float, float]:
    """Return the two values on either side and the share of the way from the first to the second, at the map's edge at most."""
    i = int(np.clip(np.searchsorted(logs, log) - 1, 0, len(values) - 2))
    share = float(np.clip((log - logs[i]) / (logs[i + 1] - logs[i]), 0.0, 1.0))
    return values[i], values[i + 1], share
