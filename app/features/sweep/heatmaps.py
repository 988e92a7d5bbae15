"""Pictures of a sweep, PNG and SVG."""

from collections.abc import Mapping
from itertools import product
from pathlib import Path
from typing import Any, Final

import numpy as np

from app.theme import PALETTES
from controllers.kinematics import Array
from scenes.files import written
from scenes.setting_spec import Spec
from scenes.settings import RunSettings, specs, values
from scenes.sweep import FIGURES, Axis, Grid, SweepFigures, is_scale

MOST_PANELS: Final = 12
MOST_LINES: Final = 8

SHOWN: Final = {
    "d_min": ("Smallest distance", r"$d_\mathrm{min}$", "mm", 1000.0),
    "e2_max": ("Largest squared error", r"$e^2_\mathrm{max}$", "", 1.0),
    "ddq_max": ("Largest joint acceleration", r"$\ddot q_\mathrm{max}$", "rad/s²", 1.0),
}
"""Figure → name, symbol, shown unit ("" if the scene decides), and factor to it."""

_LIGHT: Final = PALETTES["light"]
_COLOURS: Final = (*_LIGHT.joints, _LIGHT.resting)
_DASHES: Final = ("-", "--", "-.", ":")
_MARKERS: Final = "osD^vPX*"


def draw_maps(grid: Grid, rows: Mapping[int, SweepFigures], folder: Path) -> list[Path]:
    """Draw the `SHOWN` figures of a complete sweep; no files if there are too many panels.

    Numbers come first on the axes, choices as lines or side by side.
    """
    plan = HeatmapPlan(grid, rows)
    if len(plan.panels) > MOST_PANELS:
        return []
    import matplotlib

    drawn: list[Path] = []
    for name in SHOWN:
        # No date and a fixed salt: the same sweep gives the same bytes.
        with matplotlib.rc_context({"svg.hashsalt": "duet", "font.size": 10.0}):
            figure = heatmap_figure(plan, name)
            for form, metadata in (("png", {"Software": None}), ("svg", {"Date": None, "Creator": None})):
                path = folder / f"{name}.{form}"
                with written(path, "out") as new:
                    figure.savefig(new, format=form, dpi=160, metadata=metadata)
                drawn.append(path)
    return drawn


class HeatmapPlan:
    """Use of the axes.

    Attributes:
        y: None for lines.
        series: a line each; None for a heat map, or a single line.
        panels: index of a value for each of `beside`.
        critical: d_m, of the grid's shape [m].
    """

    def __init__(self, grid: Grid, rows: Mapping[int, SweepFigures]) -> None:
        self.grid, self.specs = grid, specs(RunSettings)
        order = sorted(grid.axes, key=lambda axis: not is_scale(axis))
        self.x, *others = order
        self.y = others.pop(0) if others and is_scale(others[0]) else None
        self.series = (
            others.pop(0) if self.y is None and others and len(others[0].values) <= MOST_LINES else None
        )
        self.beside = others
        self.panels = list(product(*(range(len(axis.values)) for axis in others)))
        table = np.array([rows[index] for index in range(grid.size)], float).reshape(
            *grid.shape, len(FIGURES)
        )
        self._figures = {name: table[..., i] for i, name in enumerate(FIGURES)}
        self.critical = np.array([values(grid.at(point))["dm"] for point in grid.points()]).reshape(
            grid.shape
        )

    def figure(self, name: str) -> Array:
        """In the shown unit, of the grid's shape; nan where not finite."""
        field = self._figures[name] * SHOWN[name][3]
        return np.where(np.isfinite(field), field, np.nan)

    def named(self, name: str) -> str:
        _, symbol, unit, _ = SHOWN[name]
        if not unit:
            units = {self.grid.at(point).experiment.error_unit for point in self.grid.points()}
            unit = " or ".join(sorted(units))
        return f"{symbol} [{unit}]"

    def part(self, field: Array, panel: tuple[int, ...]) -> Array:
        """A panel's part of a field: (y, x), (series, x) or (1, x)."""
        order = (*self.beside, self.y or self.series, self.x)
        ordered = np.transpose(field, [self.grid.axes.index(axis) for axis in order if axis is not None])
        return np.atleast_2d(ordered[panel])

    def title(self, panel: tuple[int, ...]) -> str:
        return ", ".join(
            f"{self.symbol(axis)} = {self.shown(axis, i)}" for axis, i in zip(self.beside, panel, strict=True)
        )

    def spec(self, axis: Axis) -> Spec:
        return self.specs[axis.key]

    def symbol(self, axis: Axis) -> str:
        label = self.spec(axis).label
        head, _, index = label.partition("_")
        if len(head) > 1 or " " in label:
            return label
        return f"${head}_\\mathrm{{{index}}}$" if index else f"${head}$"

    def label(self, axis: Axis) -> str:
        unit = self.spec(axis).page_unit or self.spec(axis).unit
        return f"{self.symbol(axis)} [{unit}]" if unit else self.symbol(axis)

    def shown(self, axis: Axis, i: int) -> str:
        value = axis.values[i]
        if isinstance(value, bool):
            return "on" if value else "off"
        if isinstance(value, str):
            return value.replace("_", " ")
        unit = self.spec(axis).page_unit or self.spec(axis).unit
        return f"{value * self.spec(axis).page_scale:g} {unit}".strip()

    def places(self, axis: Axis) -> Array:
        """Positions (k,) in the page's unit; 0, 1, … for choices."""
        if not is_scale(axis):
            return np.arange(len(axis.values), dtype=float)
        return np.array(axis.values, float) * self.spec(axis).page_scale

    def footnote(self) -> str:
        usual = values(RunSettings())
        fixed = self.grid.fixed()
        parts = [f"{key} = {value}" for key, value in fixed.items() if value != usual[key] or key == "scene"]
        return ", ".join((*parts, f"{self.grid.seconds:g} s"))


def heatmap_figure(plan: HeatmapPlan, name: str) -> Any:
    from matplotlib.figure import Figure

    columns = min(len(plan.panels), 3)
    lines = -(-len(plan.panels) // columns)
    figure = Figure(
        figsize=((1.2 if plan.y else 2.2) + 4.4 * columns, 0.9 + 3.6 * lines), layout="constrained"
    )
    axes = figure.subplots(lines, columns, squeeze=False, sharex=True, sharey=True)
    flat = list(axes.flat)
    for spare in flat[len(plan.panels) :]:
        spare.set_visible(False)
    used = flat[: len(plan.panels)]
    what, symbol, *_ = SHOWN[name]
    if plan.y is None:
        _draw_lines(plan, name, figure, used)
    else:
        _draw_heat(plan, name, figure, used)
    for place, (panel, ax) in enumerate(zip(plan.panels, used, strict=True)):
        _ticks(plan, plan.x, ax.xaxis)
        if plan.y:
            _ticks(plan, plan.y, ax.yaxis)
        ax.set_title(plan.title(panel), fontsize=10)
        if place + columns >= len(used):
            ax.set_xlabel(plan.label(plan.x))
            ax.tick_params(labelbottom=True)
        if place % columns == 0:
            ax.set_ylabel(plan.label(plan.y) if plan.y else plan.named(name))
    figure.suptitle(f"{what} {symbol}", fontsize=12)
    figure.supxlabel(plan.footnote(), fontsize=8, color=_LIGHT.soft)
    return figure


def _draw_heat(plan: HeatmapPlan, name: str, figure: Any, used: list[Any]) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patheffects import withStroke

    assert plan.y is not None
    whole = plan.figure(name)
    norm, colours = _scale(plan, name)
    x, y = plan.places(plan.x), plan.places(plan.y)
    gap = plan.figure("d_min") / 1000.0 - plan.critical
    crossed, mesh = False, None
    for panel, ax in zip(plan.panels, used, strict=True):
        mesh = ax.pcolormesh(
            _edges(x), _edges(y), plan.part(whole, panel), norm=norm, cmap=colours, rasterized=True
        )
        margin = plan.part(gap, panel)
        if min(margin.shape) > 1 and (margin < 0.0).any() and (margin > 0.0).any():
            crossed = True
            line = ax.contour(x, y, margin, levels=[0.0], colors="white", linewidths=1.8)
            line.set(path_effects=[withStroke(linewidth=4.0, foreground="black")])
    figure.colorbar(mesh, ax=used, label=plan.named(name))
    if crossed:
        key = Line2D(
            [], [], color="white", linewidth=1.8, path_effects=[withStroke(linewidth=4.0, foreground="black")]
        )
        used[0].legend([key], [r"$d_\mathrm{min} = d_m$"], loc="best", fontsize=9, facecolor=_LIGHT.line)
    else:
        known = gap[np.isfinite(gap)]
        sign = "≥" if (known >= 0.0).all() else "<" if (known < 0.0).all() else ""
        if known.size and sign:
            used[0].text(
                0.98, 0.97, rf"$d_\mathrm{{min}}$ {sign} $d_m$ everywhere", transform=used[0].transAxes, ha="right", va="top",
                fontsize=9, bbox={"boxstyle": "round", "facecolor": "white", "alpha": 0.8},
            )  # fmt: skip


def _scale(plan: HeatmapPlan, name: str) -> tuple[Any, str]:
    """Safe for colour-blind people."""
    from matplotlib.colors import LogNorm, Normalize, TwoSlopeNorm

    whole = plan.figure(name)
    finite = whole[np.isfinite(whole)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
    critical = float(plan.critical.flat[0]) * 1000.0
    if name == "d_min" and np.ptp(plan.critical) == 0.0 and low < critical < high:
        # Two hues meet at d_m.
        return TwoSlopeNorm(critical, low, high), "PuOr"
    if low > 0.0 and high > 30.0 * low:
        # A linear scale would show only the largest values.
        return LogNorm(low, high), "viridis"
    return Normalize(low, high if high > low else low + 1.0), "viridis"


def _ticks(plan: HeatmapPlan, axis: Axis, scale: Any) -> None:
    places = plan.places(axis)
    if not is_scale(axis):
        scale.set_ticks(places, [plan.shown(axis, i) for i in range(len(places))])
    elif len(places) <= 10:
        scale.set_ticks(places, [f"{place:g}" for place in places])
    elif not np.any(places % 1.0):
        scale.get_major_locator().set_params(integer=True)


def _draw_lines(plan: HeatmapPlan, name: str, figure: Any, used: list[Any]) -> None:
    whole, x = plan.figure(name), plan.places(plan.x)
    for panel, ax in zip(plan.panels, used, strict=True):
        for i, line in enumerate(plan.part(whole, panel)):
            label = plan.shown(plan.series, i) if plan.series else None
            style = {
                "color": _COLOURS[i % len(_COLOURS)],
                "marker": _MARKERS[i % len(_MARKERS)],
                "linestyle": _DASHES[i % len(_DASHES)] if is_scale(plan.x) else "none",
            }
            ax.plot(x, line, markersize=5, label=label, **style)
        if name == "d_min":
            critical = plan.part(plan.critical, panel)[0] * 1000.0
            ax.plot(x, critical, color="black", linewidth=1.0, linestyle=(0, (1, 1)), label="$d_m$")
        if not is_scale(plan.x):
            ax.margins(x=0.15)
        ax.grid(color=_LIGHT.edge, linewidth=0.6)
    if plan.series or name == "d_min":
        title = plan.symbol(plan.series) if plan.series else None
        figure.legend(
            *used[0].get_legend_handles_labels(), loc="outside right upper", fontsize=9, title=title
        )
    known = whole[np.isfinite(whole) & (whole > 0.0)]
    if name == "ddq_max" and known.size and known.max() > 30.0 * known.min():
        if (whole == 0.0).any():
            used[0].set_yscale("symlog", linthresh=float(known.min()))
        else:
            used[0].set_yscale("log")


def _edges(places: Array) -> Array:
    """Borders (k + 1,) of cells."""
    if len(places) == 1:
        return places[0] + np.array([-0.5, 0.5])
    middle = (places[1:] + places[:-1]) / 2.0
    return np.concatenate([[2.0 * places[0] - middle[0]], middle, [2.0 * places[-1] - middle[-1]]])
