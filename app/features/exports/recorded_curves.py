"""Curves of a recorded run, in the current language."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from app.i18n.speaking import tr
from app.plots.bins import STEEP
from app.plots.pair_strips import ROWS, pair_name
from app.plots.plot_choice import cells
from app.plots.stability_text import keeps_its_task_clear, task_error
from app.plots.time_plots import LEAST, colour_of, time_plot_of
from app.plots.time_series import COLUMNS, Swivel, signals
from app.session.frame import contact
from app.session.replay import Replay, make_film
from app.settings import Details, Theme
from app.text.first_task_texts import wording
from app.theme import PALETTES, Palette
from controllers.kinematics import Array
from controllers.stability import analyse
from scenes.history import COLUMN, SCALARS
from scenes.inputs import Recorded
from scenes.rerun import begun
from scenes.settings import RunSettings
from scenes.wanted import while_wanted

MOMENTS: Final = 240
"""Moments at which section III is evaluated."""

NOT_OVER_TIME: Final = ("curve", "laws")
"""Plots that are not over time."""

OF_OTHER_RUNS: Final = ("map", "safety", "microscope", "laps", "joint_laps")
"""Left out, as they need other runs."""


@dataclass(frozen=True)
class Stroke:
    """One line.

    Attributes:
        name: in the legend, with <sub>, or "".
        width, dash: [px]; () for a solid line.
        values: (k,), nan if missing.
        steps: a strip, in which each value holds until the next.
    """

    name: str
    colour: str
    width: float
    dash: tuple[float, ...]
    values: Array
    steps: bool = False


@dataclass(frozen=True)
class Panel:
    """One plot over time.

    Attributes:
        times: (k,) [s].
        rows: names of 0, 1, … on the axis; () for an axis of numbers.
        note: sentence in place of the lines.
    """

    title: str
    unit: str
    times: Array
    strokes: tuple[Stroke, ...]
    limits: tuple[float, float]
    rows: tuple[str, ...] = ()
    note: str = ""


class Curves:
    """Lines of one run. `table`: its newest rows (k ≥ 1, columns of `scenes.history`), one per step."""

    def __init__(self, recorded: Recorded, table: Array, theme: Theme = "light") -> None:
        self._recorded = recorded
        self._palette: Palette = PALETTES[theme]
        self._simulation = begun(recorded)
        self._simulation.apply(self.settings)
        self.table, ends = thinned_table(table)
        """History of at most `POINTS` rows."""
        self._steps = ends + (recorded.steps - len(table))
        bounds = np.cumsum([stretch.targets.steps for stretch in recorded.stretches])
        places = np.searchsorted(bounds, self._steps, side="right")
        stretches = enumerate(recorded.stretches)
        self._columns = np.concatenate(
            [signals(self._simulation, stretch.settings, self.table[places == i]) for i, stretch in stretches]
        )

    @property
    def times(self) -> Array:
        """(k,) [s]."""
        return self.table[:, COLUMN["t"]]

    @property
    def settings(self) -> RunSettings:
        return self._recorded.stretches[-1].settings

    def panels(self, details: Details, only: tuple[str, ...] = ()) -> tuple[Panel, ...]:
        """The first two plots or `only`, and the chosen one; `NOT_OVER_TIME` gives λ over time."""
        shown = "lambda" if details in NOT_OVER_TIME else "none" if details in OF_OTHER_RUNS else details
        return tuple(self._panel(name) for name in cells(self.settings, shown, only))

    def _panel(self, name: str) -> Panel:
        if name == "pairs":
            return self._pairs()
        if name == "stability":
            return self._section()
        plot = time_plot_of(name, self._simulation)
        drawn = [(line, self.column(line.column) * plot.scale) for line in plot.lines if line.run == "own"]
        strokes = tuple(
            Stroke(
                tr(line.name) if line.name else "",
                colour_of(line, self._palette),
                line.width,
                line.dash,
                values,
            )
            for line, values in drawn
        )
        limits = plot.span or _around(
            (values for line, values in drawn if line.held), plot.positive, plot.top
        )
        return Panel(without_tags(tr(plot.title)), plot.unit, self.times, strokes, limits)

    def column(self, name: str) -> Array:
        """(k,). `name`: of `app.plots.time_series.NAMES`."""
        if name != "elbow":
            return self._columns[:, COLUMNS[name]]
        swivel = Swivel(self._simulation.room, self._simulation.avoiding)
        positions = self._simulation.history.positions(self.table)
        return np.array([swivel.angle(np.ascontiguousarray(q)) for q in positions])

    def _pairs(self) -> Panel:
        pairs = self.column("pair").astype(int)
        held, counts = np.unique(pairs[pairs >= 0], return_counts=True)
        shown = np.sort(held[np.argsort(-counts, kind="stable")[:ROWS]])
        values = np.full(len(pairs), np.nan)
        for row, pair in enumerate(shown.tolist()):
            values[pairs == pair] = row
        names = tuple(pair_name(self._simulation, pair) for pair in shown.tolist())
        strokes = (Stroke("", self._palette.distance, 7.0, (), values, True),)
        title = tr(wording("the closest pair", self.settings.quantity))
        return Panel(title, "", self.times, strokes, (-0.6, max(len(shown), 1) - 0.4), names)

    def _section(self) -> Panel:
        run, title = self.settings, tr("smallest eigenvalue of sym(M) over K, and 1 − λρ²")
        by_eq_12 = all(stretch.settings.law.entry.of_section_iii for stretch in self._recorded.stretches)
        replay = Replay(make_film(self._recorded))
        of_one = not run.one_row and keeps_its_task_clear(replay.simulation)
        if self._recorded.law is not None or not by_eq_12 or not of_one or run.gain <= 0.0:
            note = tr("Section III is about eq. (12), one arm and a gain K > 0; of this run it says nothing.")
            return Panel(title, "", self.times, (), (0.0, 1.0), note=note)
        picked = np.unique(np.linspace(0, len(self._steps) - 1, MOMENTS).astype(int))
        least, survival = [], []
        for step in while_wanted(self._steps[picked].tolist()):
            replay.seek_step(step + 1)
            simulation, sample = replay.simulation, replay.simulation.sample()
            _, J = task_error(simulation, sample)
            gain = simulation.settings.gain
            analysis = analyse(contact(simulation, sample).row, J, sample.activation, gain, gain, damped=True)
            least.append(analysis.smallest_eigenvalue / gain)
            survival.append(analysis.survival)
        strokes = (
            Stroke(tr("eigenvalue / K"), self._palette.distance, 2.0, (), np.array(least)),
            Stroke("1 − λρ²", self._palette.activation, 1.8, (7.0, 4.0), np.array(survival)),
        )
        return Panel(
            title,
            "",
            self.times[picked],
            strokes,
            _around((stroke.values for stroke in strokes), positive=False),
        )


def _around(lines: Iterable[Array], positive: bool, top: float = LEAST) -> tuple[float, float]:
    """Limits as in `app.plots.time_plots.TimePlot`."""
    known = np.concatenate([*(line[np.isfinite(line)] for line in lines), np.empty(0)])
    if not len(known):
        return 0.0, 1.0
    low, high = float(known.min()), float(known.max())
    if positive:
        return min(1.08 * low, 0.0), 1.08 * high if high > top else top
    edge = max(0.1 * (high - low), 0.005)
    return low - edge, high + edge


def without_tags(html: str) -> str:
    return re.sub(r"<[^>]*>", "", html)


# ---- a long run in few rows: steps of the run itself, chosen so that every dip, every peak and every jump is among them --------

POINTS: Final = 3_200
"""Most points of a line."""

BINS: Final = 400
"""Pieces of a long run; each keeps its ends and the steps farthest off the line between them."""

VISIBLE: Final = 1.0 / 600.0
"""Visible deviation from the line [share of the signal's range]."""

_FIRST: Final = (COLUMN["d"], COLUMN["e2"])
"""Columns that always keep their extremes."""

_HIDDEN: Final = [COLUMN[name] for name in SCALARS if name not in ("d", "lambda", "e2", "u", "w", "e2_b")]
"""Columns of no plot over time, or of strips."""


def thinned_table(table: Array) -> tuple[Array, np.ndarray]:
    """At most `POINTS` rows and their indices (k,), with extremes and jumps of every signal."""
    count = len(table)
    if count <= POINTS:
        return table, np.arange(count)
    finite = np.where(np.isfinite(table), table, np.nan)
    known = np.delete(np.arange(table.shape[1]), _HIDDEN)
    known = known[~np.isnan(finite[:, known]).all(axis=0)]
    ranges = np.nanmax(finite[:, known], axis=0) - np.nanmin(finite[:, known], axis=0)
    moving, ranges = known[ranges > 0.0], ranges[ranges > 0.0]
    seen, first = finite[:, moving] / ranges, np.flatnonzero(np.isin(moving, _FIRST))
    edges = np.unique(np.linspace(0, count - 1, BINS + 1).astype(int))
    kept = [edges]
    for begin, end in pairwise(edges.tolist()):
        piece = np.nan_to_num(seen[begin : end + 1])
        if len(piece) > 2:
            kept.append(begin + _corners(piece, first))
    rows = np.unique(np.concatenate(kept))
    return table[rows], rows


def _corners(piece: Array, first: np.ndarray) -> np.ndarray:
    """`piece`: signals (rows, columns) over their range; `first`: columns whose extremes come first."""
    steps, every = np.abs(np.diff(piece, axis=0)), np.arange(piece.shape[1])
    off = piece - (piece[0] + np.linspace(0.0, 1.0, len(piece))[:, None] * (piece[-1] - piece[0]))
    worth: dict[int, float] = {}
    jumps = steps.argmax(axis=0)
    sizes = steps[jumps, every]
    jump = (sizes > VISIBLE) & (sizes * len(piece) > STEEP * np.ptp(piece, axis=0))
    for column, row in zip(every[jump].tolist(), jumps[jump].tolist(), strict=True):
        for place in (row, row + 1):
            worth[place] = max(worth.get(place, 0.0), float(sizes[column]))
    for rows in (piece.argmin(axis=0), piece.argmax(axis=0)):
        far = np.abs(off[rows, every])
        far[first] *= 1e6
        for column, row in zip(every[far > VISIBLE].tolist(), rows[far > VISIBLE].tolist(), strict=True):
            worth[row] = max(worth.get(row, 0.0), float(far[column]))
    return np.array(sorted(worth, key=lambda row: -worth[row])[: POINTS // BINS - 1], int)
