"""The time plots of page, exports and offline player.

A plot has the same lines in every experiment, some of them empty: if a plot is replaced while its data
change, viser keeps the old time axis in the wrong proportion.
"""

import math
from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from app.i18n.speaking import N_, tr
from app.plots.bins import HIGH, LOW
from app.plots.pair_strips import arm_colour
from app.plots.time_series import DRIVEN, JOINTS
from app.text.first_task_texts import wording
from app.theme import SYMBOL_COLOURS, Palette
from controllers.kinematics import Array
from scenes.law_answers import LawOfFile
from scenes.quantities import DISTANCE, KeptQuantity
from scenes.simulation import Simulation

CEILING: Final = 0.4
"""Top of the distance axis, unless d is larger [m]: Fig. 5."""

LEAST: Final = 0.01
"""Shortest axis that follows the data, in its unit, to hide noise."""

ROWS: Final = 300.0

DEGREES: Final = 180.0 / math.pi

_STYLES: Final = ((), (7.0, 4.0), (2.0, 3.0))
"""Dashes of joints 1–3, 4–6 and 7."""

_GHOST: Final = (5.0, 4.0)
_WHAT_IF: Final = (9.0, 3.0, 2.0, 3.0)
_GHOST_JOINT: Final = (8.0, 2.5, 2.0, 2.5)

_RUNS: Final = {"ghost": N_("ghost"), "what_if": N_("what if")}


@dataclass(frozen=True)
class PlotLine:
    """One line of a plot.

    Attributes:
        column: of `RollingSeries`.
        colour: CSS class: a symbol of `app.theme.SYMBOL_COLOURS`, or "j1" … of a joint.
        width: [px at a desk].
        dash: [px]; () for a solid line.
        run: "own", "ghost" or "what_if".
        name: English, with <sub>; "" for no legend entry.
        for_all: the name describes all lines with this dash.
        held: an axis that follows the data includes this line.
    """

    column: str
    colour: str
    width: float
    dash: tuple[float, ...] = ()
    run: str = "own"
    name: str = ""
    for_all: bool = False
    held: bool = True


LegendEntry = tuple[str, str, str]
"""CSS class of the colour or ""; "", "dash", "dot" or "mix"; English name."""


@dataclass(frozen=True)
class TimePlot:
    """One plot over time.

    Attributes:
        title: HTML.
        span: of the axis; None to follow the data, from 0 up if `positive`.
        scale: factor of shown values.
        positive: begin at 0, unless the data go below.
        top: least top of an axis that follows the data, in its unit.
    """

    title: str
    unit: str
    lines: tuple[PlotLine, ...]
    span: tuple[float, float] | None = None
    scale: float = 1.0
    positive: bool = True
    top: float = LEAST

    def visible(self, stats: Array) -> float:
        """Smallest visible change of a signal in its unit, about half a pixel. `stats`: (statistics, signals,
        bins), see `app.plots.bins`.
        """
        if self.span is not None:
            return (self.span[1] - self.span[0]) / self.scale / ROWS
        values = stats[[LOW, HIGH]]
        values = values[np.isfinite(values)]
        low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 0.0)
        return max(high - (min(low, 0.0) if self.positive else low), self.top / self.scale) / ROWS

    def legend(
        self, others: Collection[str] = (), names: tuple[str, str] | None = None
    ) -> tuple[LegendEntry, ...]:
        """Named lines, then other runs with lines. `names`: of own run and ghost; None for the usual ones."""
        entries = [_entry(line, line.name, line.for_all) for line in self.lines if line.name]
        if names is not None and any(line.run == "ghost" for line in self.lines):
            entries.insert(0, _entry(self.lines[0], names[0], self.lines[0].colour not in SYMBOL_COLOURS))
        for run in others:
            line = next((line for line in self.lines if line.run == run), None)
            if line is not None:
                name = names[1] if names is not None and run == "ghost" else _RUNS[run]
                entries.append(_entry(line, name, line.colour not in SYMBOL_COLOURS))
        return tuple(entries)


def _entry(line: PlotLine, name: str, for_all: bool) -> LegendEntry:
    dash = (
        "mix"
        if len(line.dash) > 2
        else "dash"
        if max(line.dash, default=0.0) > 4.0
        else "dot"
        if line.dash
        else ""
    )
    return "" if for_all else line.colour, dash, name


def _shadows(column: str, colour: str) -> tuple[PlotLine, ...]:
    return PlotLine(column, colour, 1.8, _GHOST, "ghost"), PlotLine(column, colour, 2.0, _WHAT_IF, "what_if")


def _with_ghost(column: str, colour: str) -> tuple[PlotLine, ...]:
    return PlotLine(column, colour, 2.2), _shadows(column, colour)[0]


def _joints(
    title: str, unit: str, stem: str, count: int, span: tuple[float, float] | None, scale: float
) -> TimePlot:
    numbers = range(1, JOINTS + 1)
    own = (
        PlotLine(f"{stem}{i}", f"j{i}", 1.6, _STYLES[(i - 1) // 3], name=str(i) if i <= count else "")
        for i in numbers
    )
    ghost = (PlotLine(f"{stem}{i}", f"j{i}", 1.0, _GHOST_JOINT, "ghost") for i in numbers)
    return TimePlot(title, unit, (*own, *ghost), span, scale, False)


def _distance(rests: bool, kept: KeptQuantity) -> TimePlot:
    d = kept.symbol
    lines = (
        PlotLine("d", "d", 2.2),
        PlotLine("d_m", "dm", 1.6, (7.0, 5.0), name=f"{d}<sub>m</sub>"),
        PlotLine("d*", "rest", 1.6, (2.0, 4.0), name=f"{d}*" if rests else "", held=False),
        *_shadows("d", "d"),
    )
    title = (
        N_('distance <b class="d">d</b>') if kept is DISTANCE else f'{tr(kept.short)} <b class="d">{d}</b>'
    )
    return TimePlot(title, kept.unit, lines, top=CEILING)


def _squared_error(unit: str, arms: tuple[str, str]) -> TimePlot:
    lines = (
        PlotLine("e2", "e", 2.2, name=arms[0]),
        PlotLine("e2_b", "u", 1.8, (2.0, 3.0), name=arms[1]),
        *_shadows("e2", "e"),
    )
    return TimePlot(N_('error <b class="e">e²</b>'), unit, lines)


def _followed(prefix: str, title: str, model: str) -> TimePlot:
    numbers = range(1, DRIVEN + 1)
    own = (PlotLine(f"{prefix}q{i}", f"j{i}", 2.0, name=str(i)) for i in numbers)
    desired = (
        PlotLine(f"{prefix}qd{i}", f"j{i}", 1.4, (5.0, 4.0), name=model if i == 1 else "", for_all=True)
        for i in numbers
    )
    return TimePlot(title, "°", (*own, *desired), None, DEGREES, positive=False)


TIME_PLOTS: Final[dict[str, TimePlot]] = {
    "hand": TimePlot('hand error <b class="e">|e|</b>', "mm", _with_ghost("e", "e"), scale=1000.0),
    "elbow": TimePlot("elbow angle", "°", _with_ghost("elbow", "d"), None, DEGREES, False),
    "lambda": TimePlot('activation <b class="lam">λ</b>', "", _with_ghost("lambda", "lam"), (0.0, 1.05)),
    "speeds": TimePlot(
        "speeds along the line",
        "m/s",
        (
            PlotLine("u", "u", 2.0, name="u"),
            PlotLine("v", "v", 1.8, (7.0, 5.0), name="v"),
            PlotLine("w", "w", 2.0, (2.0, 4.0), name="w"),
            PlotLine("u", "u", 1.4, _GHOST, "ghost"),
        ),
        positive=False,
    ),
}


def time_plot_of(name: str, simulation: Simulation) -> TimePlot:
    run, joints = simulation.settings, simulation.avoiding.joints
    avoiding, other = (
        arm_colour(arm.name, simulation.guided.name) for arm in (simulation.avoiding, simulation.guided)
    )
    count = min(joints.stop - joints.start, JOINTS)
    match name:
        case "error":
            two = run.experiment.follows == "person" and run.both_avoid and not run.one_row
            return _squared_error(run.experiment.error_unit, (avoiding, other) if two else ("", ""))
        case "distance":
            return _distance(run.law.entry.rests and not isinstance(simulation.law, LawOfFile), run.quantity)
        case "speeds" if run.quantity is not DISTANCE:
            plot = TIME_PLOTS[name]
            return replace(plot, title=wording(plot.title, run.quantity), unit=run.quantity.rate_unit)
        case "joints":
            return _joints(N_("joints q"), "°", "q", count, (-180.0, 180.0), DEGREES)
        case "rates":
            return _joints(N_("joint speeds q̇"), "rad/s", "dq", count, None, 1.0)
        case "follow" if run.experiment.follows == "person":
            return _followed("", tr("q, {arm} arm", arm=avoiding), N_("person"))
        case "follow":
            return _followed(
                "", N_("q, slave"), N_("master") if run.following == "identical" else N_("master, mirrored")
            )
        case "follow_other":
            return _followed("other_", tr("q, {arm} arm", arm=other), N_("person"))
        case _:
            return TIME_PLOTS[name]


def colour_of(line: PlotLine, palette: Palette) -> str:
    if line.colour not in SYMBOL_COLOURS:
        return palette.joints[int(line.colour[1:]) - 1]
    colour: str = getattr(palette, SYMBOL_COLOURS[line.colour])
    return colour
