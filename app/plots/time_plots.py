"""The plots over time: which columns, lines, colours and names each of them has.

A plot has the same lines in every experiment, and those that mean nothing there stay empty. With other lines the page would make it
anew, and when its data change in the same moment viser keeps the old time axis in the wrong proportion for good.
"""

import math
from dataclasses import dataclass, replace
from typing import Final

from app.custom_law.custom_law import CustomLaw
from app.i18n.sides import side
from app.i18n.speaking import N_, tr
from app.plots.time_series import COLUMNS, DRIVEN, JOINTS, RESTING
from app.session.relevant_settings import both_avoid
from app.theme import Palette
from scenes.simulation import Simulation

CEILING: Final = 0.4
"""Top of the distance axis [m]: Fig. 5's."""

DEGREES: Final = 180.0 / math.pi

_STYLES: Final = ((), (7.0, 4.0), (2.0, 3.0))
"""Dashes of the first three joints, the next three, the last."""

_GHOST: Final = (5.0, 4.0)
_WHAT_IF: Final = (9.0, 3.0, 2.0, 3.0)


@dataclass(frozen=True)
class PlotLine:
    """One line of a plot.

    Attributes:
        column: of the buffer.
        colour: field of `Palette`, or "joint 1" …
        width: [px at a desk].
        dash: [px]; none for a solid line.
        run: whose: the run itself ("own"), the ghost's, or what would have been ("what_if").
    """

    column: str
    colour: str
    width: float
    dash: tuple[float, ...] = ()
    run: str = "own"


@dataclass(frozen=True)
class TimePlot:
    """One plot over time.

    Attributes:
        title: as HTML.
        unit: of the axis.
        lines: in the order drawn.
        legend: class of CSS, kind of line ("", "dash", "dot", "mix") and name, for every line that needs one.
        span: of the axis; None: as the data ask, from 0 up if `positive`.
        scale: values of the buffer times this are shown.
        positive: whether the axis begins at 0.
        symbol: class of CSS of what the ghost does, too.
    """

    title: str
    unit: str
    lines: tuple[PlotLine, ...]
    legend: tuple[tuple[str, str, str], ...] = ()
    span: tuple[float, float] | None = None
    scale: float = 1.0
    positive: bool = True
    symbol: str = ""

    def columns(self, run: str) -> tuple[int, ...]:
        """Return the columns of the buffer of one run, in the order of the lines."""
        return tuple(COLUMNS[line.column] for line in self.lines if line.run == run)


def _shadows(column: str, colour: str) -> tuple[PlotLine, ...]:
    """Return what the ghost did and what would have been, in the same colour."""
    return PlotLine(column, colour, 1.8, _GHOST, "ghost"), PlotLine(column, colour, 2.0, _WHAT_IF, "what_if")


def _joints(stem: str, run: str = "own") -> tuple[PlotLine, ...]:
    thin, dash = (1.6, None) if run == "own" else (1.0, (1.5, 3.0))
    return tuple(
        PlotLine(f"{stem}{i + 1}", f"joint {i + 1}", thin, _STYLES[i // 3] if dash is None else dash, run) for i in range(JOINTS)
    )


def _of_joints(title: str, unit: str, stem: str, count: int, span: tuple[float, float] | None) -> TimePlot:
    legend = tuple((f"j{i + 1}", ("", "dash", "dot")[i // 3], str(i + 1)) for i in range(count))
    return TimePlot(title, unit, (*_joints(stem), *_joints(stem, "ghost")), legend, span, DEGREES, False)


_DISTANCE: Final = TimePlot(
    N_('distance <b class="d">d</b>'),
    "m",
    (
        PlotLine("d", "distance", 2.2),
        PlotLine("d_m", "critical", 1.6, (7.0, 5.0)),
        PlotLine("d*", "resting", 1.6, (2.0, 4.0)),
        *_shadows("d", "distance"),
    ),
    (("dm", "dash", "d<sub>m</sub>"), ("rest", "dot", "d*")),
    (0.0, CEILING),
    symbol="d",
)


def _squared_error(unit: str, arms: tuple[str, ...]) -> TimePlot:
    lines = (PlotLine("e2", "error", 2.2), PlotLine("e2_b", "pull", 1.8, (2.0, 3.0)), *_shadows("e2", "error"))
    legend = tuple(zip(("e", "u"), ("", "dot"), arms, strict=True)) if len(arms) > 1 else ()
    return TimePlot(N_('error <b class="e">e²</b>'), unit, lines, legend, symbol="e")


def _followed(prefix: str, title: str, model: str) -> TimePlot:
    own = tuple(PlotLine(f"{prefix}q{i + 1}", f"joint {i + 1}", 2.0) for i in range(DRIVEN))
    desired = tuple(PlotLine(f"{prefix}qd{i + 1}", f"joint {i + 1}", 1.4, (5.0, 4.0)) for i in range(DRIVEN))
    names = tuple((f"j{i + 1}", "", str(i + 1)) for i in range(DRIVEN))
    return TimePlot(title, "°", (*own, *desired), (*names, ("", "dash", model)), None, DEGREES, positive=False)


COURSES: Final[dict[str, TimePlot]] = {
    "hand": TimePlot('hand error <b class="e">|e|</b>', "mm", (PlotLine("e", "error", 2.2),), scale=1000.0),
    "elbow": TimePlot("elbow angle", "°", (PlotLine("elbow", "distance", 2.2),), (), None, DEGREES, False),
    "lambda": TimePlot(
        'activation <b class="lam">λ</b>',
        "",
        (PlotLine("lambda", "activation", 2.2), PlotLine("lambda", "activation", 1.8, _GHOST, "ghost")),
        (),
        (0.0, 1.05),
        symbol="lam",
    ),
    "speeds": TimePlot(
        "speeds along the line",
        "m/s",
        (
            PlotLine("u", "pull", 2.0),
            PlotLine("v", "velocity", 1.8, (7.0, 5.0)),
            PlotLine("w", "approach", 2.0, (2.0, 4.0)),
            PlotLine("u", "pull", 1.4, _GHOST, "ghost"),
        ),
        (("u", "", "u"), ("v", "dash", "v"), ("w", "dot", "w")),
        positive=False,
        symbol="u",
    ),
}


def time_plot_of(name: str, simulation: Simulation) -> TimePlot:
    """Return a plot, named "distance", "error", …, as it is in a run."""
    run, joints = simulation.settings, simulation.avoiding.joints
    avoiding, other = simulation.avoiding.name, simulation.guided.name
    count = min(joints.stop - joints.start, JOINTS)
    match name:
        case "error":
            two = run.scene == "imitation" and both_avoid(run) and not run.law.coupled
            return _squared_error(simulation.error_unit, (side(avoiding), side(other)) if two else (side(avoiding),))
        case "distance":
            rests = run.law.law in RESTING and not isinstance(simulation.law, CustomLaw)
            return _DISTANCE if rests else replace(_DISTANCE, legend=_DISTANCE.legend[:1])
        case "joints":
            return _of_joints(N_("joints q"), "°", "q", count, (-180.0, 180.0))
        case "rates":
            return _of_joints(N_("joint speeds q̇"), "°/s", "dq", count, None)
        case "follow" if run.scene == "imitation":
            return _followed("", tr("q, {arm} arm", arm=side(avoiding)), N_("person"))
        case "follow":
            return _followed("", N_("q, slave"), N_("master") if run.following == "identical" else N_("master, mirrored"))
        case "follow_other":
            return _followed("other_", tr("q, {arm} arm", arm=side(other)), N_("person"))
        case _:
            return COURSES[name]


def colour_of(line: PlotLine, palette: Palette) -> str:
    """Return the colour of a line as CSS."""
    if line.colour.startswith("joint "):
        return palette.joints[int(line.colour[6:]) - 1]
    colour: str = getattr(palette, line.colour)
    return colour
