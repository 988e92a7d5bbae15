"""Two runs of one attack in one chart: how far apart the arms were, with the visitor at the lever and with a law, over the whole run."""

from typing import Final

import numpy as np
from markupsafe import Markup

from app.i18n.speaking import decimal
from app.plots.chart import Chart, ChartAxes
from app.text.templates import element, macros
from controllers.kinematics import Array
from scenes.history import COLUMN
from scenes.simulation import Simulation

COUNT: Final = 240
"""Points of a track: the smallest distance in each of so many parts of the run."""

HEIGHT: Final = 150
"""[CSS px]"""


def tracks_html(own: Simulation, rival: Simulation, names: tuple[str, str]) -> Markup:
    """Return the chart, with d_m in it.

    Args:
        own, rival: at the end of runs of the same length, of which all steps are known.
        names: of the two.
    """
    end, critical = own.time, own.settings.law.critical_distance
    tracks = [_track(run.history.table()) for run in (own, rival)]
    low, high = min(-0.05, *(float(ys.min()) for _, ys in tracks)), max(float(ys.max()) for _, ys in tracks)
    levels = [(k / 10.0, f"{100 * k}".replace("-", "−")) for k in range(int(np.ceil(10.0 * low)), int(10.0 * high) + 1)]
    times = [(t, decimal(f"{t:.3g}") + (" s" if t == end else "")) for t in np.linspace(0.0, end, 5).tolist()]
    chart = Chart(ChartAxes((0.0, end), (low, 1.05 * high), tuple(times), tuple(levels)))
    chart.level(critical, "dm", 1.6, "7 5")
    for (xs, ys), kind, dash in zip(tracks, ("lam", "d"), ("", "5 3"), strict=True):
        chart.line(xs, ys, kind, 1.8, dash)
    lines = [("lam", "", names[0]), ("d", "dash", names[1]), ("dm", "dash", Markup("d<sub>m</sub>"))]
    title = Markup('<b class="d">d</b>')
    made = macros("plots/charts.html").caption(title, "mm", lines, False, False) + chart.html(HEIGHT)
    return element("div", "", made, class_="duet duet-lesson duet-l-tracks")


def _track(table: Array) -> tuple[Array, Array]:
    parts = np.array_split(table[:, [COLUMN["t"], COLUMN["d"]]], min(COUNT, len(table)))
    lowest = np.array([part[part[:, 1].argmin()] for part in parts])
    return lowest[:, 0], lowest[:, 1]
