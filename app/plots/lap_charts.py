"""Laps of a circle, of the hand or two joints, with magnified ends."""

import math

import numpy as np
from markupsafe import Markup

from app.i18n.speaking import tr
from app.plots.chart import Chart, ChartAxes, ticks_of
from app.text.templates import macros
from controllers.errors import NumberText
from controllers.kinematics import Array, Kinematics
from scenes.arm_tasks.hold_task import HoldTask
from scenes.simulation import Simulation
from scenes.solo import LAP

SHOWN = 2

COARSE = 80

NEAR = 0.15
"""Time around a lap's end with all steps drawn [s]."""

BESIDE = 30
"""Height of a chart minus its axis width [CSS px]."""

LETTER = 6.5
"""Approximate width of a letter [CSS px]."""

LEAST = {"mm": 0.2, "°": 0.5}
"""Least half-width of the magnified part [displayed unit]."""


def laps_html(simulation: Simulation, ghost: Simulation | None, joints: bool, height: int) -> Markup:
    """Whole path and magnified ends, the ghost's dashed. `joints`: show the two joints that turn most, not
    the hand; `height`: [CSS px].
    """
    if simulation.history.count < 2:
        return Markup()
    first, last = _laps(simulation)
    times, places, names = _way(simulation, first, joints)
    unit = "°" if joints else "mm"
    # Lap ends are between two steps, in a replay between two kept moments.
    laps = np.arange(first, last + 1)
    ends = np.stack([np.interp(laps * LAP, times, line) for line in places.T], axis=1)
    gaps = ends - ends[:1]
    reach = np.ptp(places, axis=0)
    # The gap need not lie in the plane of the circle.
    most, open_most = (
        sorted(np.argsort(sizes)[-2:].tolist())
        for sizes in (reach, np.abs(gaps).max(axis=0) if last > first else reach)
    )
    whole, near = places[:, most], places[:, open_most]
    edge = np.maximum(0.08 * np.ptp(whole, axis=0), LEAST[unit])
    half = max(1.6 * float(np.abs(gaps[:, open_most]).max(initial=0.0)), LEAST[unit])
    size = height - 30
    left = _chart(whole.min(axis=0) - edge, whole.max(axis=0) + edge, size - BESIDE)
    middle = ends[0, open_most] if len(ends) else near[0]
    right = _chart(middle - half, middle + half, size - BESIDE)
    left.line(whole[:, 0], whole[:, 1], "d", 1.6)
    left.mark(whole[0, 0], whole[0, 1], "dot d")
    if ghost is not None and ghost.history.count > 1:
        before, others, _ = _way(ghost, first, joints)
        for piece in _pieces(before, others[:, open_most]):
            right.line(piece[:, 0], piece[:, 1], "d", 1.2, "5 4")
    for piece in _pieces(times, near):
        right.line(piece[:, 0], piece[:, 1], "d", 1.6)
    for lap, (x, y) in zip(laps.tolist(), ends[:, open_most].tolist(), strict=True):
        right.mark(x, y, "digit d", str(lap))
    said = [
        tr("lap {lap}: {gap}", lap=lap, gap=NumberText(f"{float(np.linalg.norm(gap)):.2f} {unit}"))
        for lap, gap in enumerate(gaps[1:], first + 1)
    ]
    x, y = (names[axis] for axis in open_most)
    words = tr("At the right the ends of the laps, magnified: {x} and {y} [{unit}].", x=x, y=y, unit=unit)
    return macros("plots/charts.html").laps(left.html(size), right.html(size), size + 20, words, said)


def _way(simulation: Simulation, first: int, joints: bool) -> tuple[Array, Array, tuple[str, ...]]:
    """Times since the first lap began (k,) [s], places (k, axes) [mm or °] and axis names, from lap `first`
    on.
    """
    arm, dt = simulation.avoiding, simulation.settings.dt
    kept = _times(simulation)
    start = int(np.searchsorted(kept, first * LAP - 0.5 * dt))
    times, table = kept[start:], simulation.history.table(len(kept) - start)
    every = max(round(LAP / dt / COARSE), 1)
    from_end = np.abs((times + LAP / 2.0) % LAP - LAP / 2.0)
    rows = np.flatnonzero((np.arange(len(times)) % every == 0) | (from_end < NEAR))
    positions = simulation.history.positions(table[rows])
    if joints:
        angles = np.degrees(positions[:, arm.joints])
        return times[rows], angles, tuple(f"q{i + 1}" for i in range(angles.shape[1]))
    kinematics, hands = Kinematics(simulation.room.model, simulation.room.arms), list[Array]()
    for q in positions:
        kinematics.update(np.ascontiguousarray(q))
        hands.append(1000.0 * kinematics.hand_pose(arm).translation)
    return times[rows], np.array(hands) - hands[0], ("x", "y", "z")


def _times(simulation: Simulation) -> Array:
    task = simulation.roles.task
    return simulation.history.column("t") - (task.path_began if isinstance(task, HoldTask) else 0.0)


def _laps(simulation: Simulation) -> tuple[int, int]:
    """First lap end after which all steps are kept, and last one reached; smaller than the first if there is
    none.
    """
    times, dt = _times(simulation), simulation.settings.dt
    last = int((times[-1] + 0.25 * dt) // LAP)
    return max(last - SHOWN, 0, int(np.ceil((times[0] - 0.5 * dt) / LAP))), last


def _pieces(times: Array, places: Array) -> list[Array]:
    near = np.abs((times + LAP / 2.0) % LAP - LAP / 2.0) < NEAR
    cuts = np.flatnonzero(np.diff(near.astype(int))) + 1
    return [
        piece
        for piece, shown in zip(np.split(places, cuts), np.split(near, cuts), strict=True)
        if shown.any()
    ]


def _chart(low: Array, high: Array, width: int) -> Chart:
    (x0, y0), (x1, y1) = low.tolist(), high.tolist()
    ticks = ticks_of(x0, x1)
    room = LETTER * (1 + max(len(text) for _, text in ticks))
    # Two at least, however long their numbers are.
    every = math.ceil(room * (x1 - x0) / (width * (ticks[1][0] - ticks[0][0])))
    return Chart(ChartAxes((x0, x1), (y0, y1), ticks[:: min(every, len(ticks) - 1)], ticks_of(y0, y1)))
