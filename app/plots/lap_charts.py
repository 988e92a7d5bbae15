"""Lap over lap of a circle: the hand's way or that of two joints, and the place where the laps begin and end, magnified."""

import numpy as np
from markupsafe import Markup

from app.i18n.speaking import decimal, tr
from app.plots.chart import Chart, ChartAxes
from app.plots.microscope_chart import ticks_of
from app.text.templates import macros
from controllers.kinematics import Array, Kinematics
from scenes.history import COLUMN
from scenes.simulation import Simulation
from scenes.solo import LAP

COARSE = 160
"""Steps of a lap that are drawn; around the ends of the laps …"""

NEAR = 0.3
"""… all of them within this time [s]."""

LEAST = {"mm": 0.2, "°": 0.5}
"""The magnified part reaches so far to either side at least, in the unit that is shown."""


def laps_html(simulation: Simulation, ghost: Simulation | None, joints: bool, height: int) -> Markup:
    """Return the whole way and its magnified ends.

    Args:
        ghost: its ends are drawn dashed; None for no ghost.
        joints: of the two joints that turn most; otherwise of the hand.
        height: [CSS px].
    """
    times, places, names = _way(simulation, joints)
    if len(times) < 2:
        return Markup()
    unit = "°" if joints else "mm"
    count = int((float(times[-1]) + 0.25 * simulation.settings.dt) / LAP)
    ends = [int(np.abs(times - lap * LAP).argmin()) for lap in range(count + 1)]
    middle, half = places[0], max(1.6 * float(np.abs(places[ends] - places[0]).max()), LEAST[unit])
    low, high = places.min(axis=0), places.max(axis=0)
    edge = np.maximum(0.08 * (high - low), LEAST[unit])
    whole, near = _chart(low - edge, high + edge), _chart(middle - half, middle + half)
    whole.line(*places.T, "d", 1.6)
    whole.mark(*places[0], "dot d")
    if ghost is not None:
        before, others, _ = _way(ghost, joints)
        for piece in _pieces(before, others):
            near.line(*piece.T, "d", 1.2, "5 4")
    for piece in _pieces(times, places):
        near.line(*piece.T, "d", 1.6)
    for lap, end in enumerate(ends):
        near.mark(*places[end], "digit d", str(lap))
    gaps = [
        tr("lap {lap}: {gap}", lap=lap, gap=decimal(f"{float(np.linalg.norm(places[end] - places[0])):.2f} {unit}"))
        for lap, end in enumerate(ends[1:], 1)
    ]
    words = tr("{x} and {y} [{unit}]; at the right the ends of the laps, magnified.", x=names[0], y=names[1], unit=unit)
    size = height - 30
    return macros("plots/charts.html").laps(whole.html(size), near.html(size), size + 20, words, gaps)


def _way(simulation: Simulation, joints: bool) -> tuple[Array, Array, tuple[str, str]]:
    """Return times (k,) [s], places (k, 2) [mm or °] and the names of both axes, at the steps that are drawn."""
    arm, dt = simulation.avoiding, simulation.settings.dt
    table = simulation.history.table()
    times = table[:, COLUMN["t"]]
    every = max(round(LAP / dt / COARSE), 1)
    from_end = np.abs((times + LAP / 2.0) % LAP - LAP / 2.0)
    rows = np.flatnonzero((np.arange(len(times)) % every == 0) | (from_end < NEAR))
    positions = simulation.history.positions(table[rows])
    if joints:
        angles = np.degrees(positions[:, arm.joints])
        x, y = sorted(np.argsort(np.ptp(angles, axis=0) if len(angles) else angles)[-2:].tolist())
        return times[rows], angles[:, [x, y]], (f"q{x + 1}", f"q{y + 1}")
    kinematics, hands = Kinematics(simulation.room.model, simulation.room.arms), list[Array]()
    for q in positions:
        kinematics.update(np.ascontiguousarray(q))
        hands.append(1000.0 * kinematics.hand_pose(arm).translation[1:])
    places = np.array(hands).reshape(-1, 2)
    return times[rows], places - places[:1], ("y", "z")


def _pieces(times: Array, places: Array) -> list[Array]:
    """Return the pieces (k, 2) of a way that lie about the ends of the laps."""
    near = np.abs((times + LAP / 2.0) % LAP - LAP / 2.0) < NEAR
    cuts = np.flatnonzero(np.diff(near.astype(int))) + 1
    return [piece for piece, shown in zip(np.split(places, cuts), np.split(near, cuts), strict=True) if shown.any()]


def _chart(low: Array, high: Array) -> Chart:
    (x0, y0), (x1, y1) = low.tolist(), high.tolist()
    return Chart(ChartAxes((x0, x1), (y0, y1), ticks_of(x0, x1), ticks_of(y0, y1)))
