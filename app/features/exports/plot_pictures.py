"""Plots of a recorded run as PNG or SVG, with deterministic bytes."""

import io
import re
from typing import Final, Literal, cast

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from app.features.exports.csv_table import changes
from app.features.exports.recorded_curves import NOT_OVER_TIME, OF_OTHER_RUNS, Curves, Panel, Stroke
from app.features.figures.drawn_figure import COLOURS, DASHES, DPI, FAINT, INK, STYLE, sheet
from app.i18n.speaking import tr
from app.plots.law_charts import FAR, ORDERS, all_laws, distances
from app.recording.run_file import made_here
from app.session.frame import contact
from app.session.replay import Replay, make_film
from app.settings import Details
from app.text.first_task_texts import in_symbols, over_name
from app.text.setting_values import page_value
from app.theme import PALETTES
from controllers.activation import activation
from controllers.kinematics import Array
from scenes.history import COLUMN
from scenes.inputs import Recorded
from scenes.law_answers import LawAnswers
from scenes.laws import LAWS
from scenes.quantities import DISTANCE
from scenes.rerun import newest_steps, rerun
from scenes.settings import LawSettings, RunSettings
from scenes.wanted import while_wanted

WIDTH: Final = 7.2
HEIGHT: Final = 1.85
"""Width of a picture and height of a panel [inch]."""

MOST_MARKS: Final = 40
"""More marks would be a grey area."""

LONGEST: Final = 2.4
"""Largest end of the axis of speeds [m/s]."""

LONGEST_CAPTION: Final = 112
"""Longest caption at full letter size [characters]."""

PictureKind = Literal["png", "svg"]


def picture_bytes(
    recorded: Recorded, seconds: float, details: Details, kind: PictureKind, only: tuple[str, ...] = ()
) -> bytes:
    """File of the plots.

    Args:
        seconds: shown time at the end [s]; inf for all.
        details: plot in addition to the first two.
        only: plots in their place.

    Raises:
        BadSetting: the run is not possible here.
    """
    # The style must not affect other pictures of this process.
    with matplotlib.rc_context(STYLE):
        figure = picture_figure(recorded, seconds, details, only)
        out = io.BytesIO()
        if kind == "png":
            figure.savefig(out, format="png", dpi=DPI, metadata={"Software": None})
        else:
            figure.savefig(out, format="svg", metadata={"Date": None, "Creator": "lwr-duet"})
    return out.getvalue()


def inline_svg(recorded: Recorded, name: str, only: tuple[str, ...] = ()) -> str:
    """<svg> element of a whole piece. `name`: letters and digits, prefix of the ids; `only`: see
    `picture_bytes`.
    """
    return embedded(picture_bytes(recorded, recorded.seconds, "none", "svg", only).decode(), name)


def embedded(svg: str, name: str) -> str:
    """<svg> element with full width, and `name` before every id."""
    svg = svg[svg.index("<svg") :].strip()
    svg = re.sub(r"(<svg[^>]*?) width=\"[^\"]*\"", r"\1", svg, count=1)
    svg = re.sub(r"(<svg[^>]*?) height=\"[^\"]*\"", r"\1", svg, count=1)
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    return re.sub(r'\bid="|xlink:href="#|url\(#', rf"\g<0>{name}-", svg)


def picture_figure(recorded: Recorded, seconds: float, details: Details, only: tuple[str, ...]) -> Figure:
    charts = [name for name in NOT_OVER_TIME if name in only]
    if charts and details == "none":
        details = cast(Details, charts[0])
    time_plots_only = tuple(name for name in only if name not in (*NOT_OVER_TIME, *OF_OTHER_RUNS))
    if recorded.law is not None and (details in NOT_OVER_TIME or details == "stability"):
        # These plots would show the law of the settings.
        details = "none"
    table = rerun(recorded).table
    curves = Curves(recorded, table[-newest_steps(recorded, seconds) :])
    other = details if details in NOT_OVER_TIME else ""
    panels = curves.panels("none" if other else details, time_plots_only)
    rows = len(panels) + bool(other)
    figure = sheet(HEIGHT * rows + 0.55, WIDTH)
    ratios = [1.0] * len(panels) + [1.5] * bool(other)
    grid = figure.subplots(rows, 1, squeeze=False, height_ratios=ratios)[:, 0]
    time_axes = grid[: len(panels)]
    marks = [time for time in sorted({time for time, _, _ in changes(recorded)}) if time > curves.times[0]]
    for axes, panel in while_wanted(zip(time_axes, panels, strict=True)):
        axes.sharex(time_axes[0])
        _draw_panel(axes, panel, marks if len(marks) <= MOST_MARKS else [])
        axes.label_outer()
    time_axes[-1].tick_params(labelbottom=True)
    time_axes[-1].set(xlabel=tr("time [s]"), xlim=(float(curves.times[0]), float(curves.times[-1]) + 1e-6))
    if other:
        replay = Replay(make_film(recorded))
        replay.seek(replay.end)
        _chart(grid[-1], other, replay, curves)
    said = caption(recorded.stretches[-1].settings, recorded.law)
    size = 8.5 * min(1.0, LONGEST_CAPTION / len(said.replace("$", "")))
    figure.suptitle(said, x=0.012, ha="left", fontsize=size, color=PALETTES["light"].soft)
    return figure


def _draw_panel(axes: Axes, panel: Panel, marks: list[float]) -> None:
    axes.set_title(f"{panel.title} [{panel.unit}]" if panel.unit else panel.title, pad=5.0)
    for time in marks:
        axes.axvline(time, color=FAINT, linewidth=1.0, zorder=0.5)
    for stroke in panel.strokes:
        if stroke.steps:
            _strips(axes, panel.times, stroke)
            continue
        axes.plot(
            panel.times,
            stroke.values,
            color=stroke.colour,
            # Widths and dashes of the page are in CSS pixels.
            linewidth=0.75 * stroke.width,
            linestyle=(0, tuple(d / stroke.width for d in stroke.dash)) if stroke.dash else "solid",
            label=mathtext(stroke.name) if stroke.name else "_",
        )
    if panel.rows:
        axes.set_yticks(range(len(panel.rows)), panel.rows, fontsize=8.5)
    axes.set_ylim(*panel.limits)
    named = sum(bool(stroke.name) for stroke in panel.strokes)
    if named:
        axes.legend(
            loc="lower right", bbox_to_anchor=(1.0, 0.98), ncols=named, borderaxespad=0.0, handlelength=1.9
        )
    if panel.note:
        axes.text(0.5, 0.5, panel.note, transform=axes.transAxes, ha="center", va="center", fontsize=9.0)
        axes.set(yticks=[])


def _strips(axes: Axes, times: Array, stroke: Stroke) -> None:
    changed = np.flatnonzero(np.diff(stroke.values, prepend=np.nan) != 0.0)
    for begin, end in zip(changed.tolist(), [*changed[1:].tolist(), len(times) - 1], strict=True):
        if not np.isnan(stroke.values[begin]):
            axes.plot(
                times[[begin, end]],
                stroke.values[[begin, begin]],
                color=stroke.colour,
                linewidth=5.0,
                solid_capstyle="butt",
            )


def _chart(axes: Axes, name: str, replay: Replay, curves: Curves) -> None:
    run = replay.simulation.settings
    law, symbol = run.law, run.quantity.symbol
    xs = distances(law)
    named = over_name(run.quantity)
    if run.quantity is DISTANCE and run.has_law_distance:
        named = tr("law distance d_law")
    elif run.has_law_distance:
        named = f"{named.removesuffix(symbol)}{symbol}_law"
    axes.set(
        xlim=(0.0, FAR),
        xlabel=f"{named} [{run.quantity.unit}]".replace(f"{symbol}_law", rf"${symbol}_\mathrm{{law}}$"),
    )
    if name == "curve":
        _activation(axes, replay, curves, xs, law)
    else:
        _laws(axes, replay, xs, law)


def _activation(axes: Axes, replay: Replay, curves: Curves, xs: np.ndarray, law: LawSettings) -> None:
    title = tr("activation λ over the distance the law acts on, and where this run was")
    if not replay.simulation.settings.quantity.against:
        title = tr("activation λ over the value the law acts on, and where this run was")
    axes.set_title(title, pad=5.0)
    for order in ORDERS:
        ys = [activation(d, law.critical_distance, order) for d in xs.tolist()]
        axes.plot(xs, ys, color=PALETTES["light"].faint, linewidth=0.9, label="_")
        axes.text(
            law.critical_distance * 0.34 ** (-1.0 / order),
            0.34,
            f"n = {order:g}",
            color=PALETTES["light"].soft,
            fontsize=8.5,
        )
    axes.plot(
        xs,
        [replay.simulation.law.activation(d) for d in xs.tolist()],
        color=COLOURS.activation,
        linewidth=1.9,
    )
    visited = curves.table[:, [COLUMN["law_d"], COLUMN["lambda"]]]
    axes.plot(
        *visited.T,
        linestyle="none",
        marker="o",
        markersize=2.2,
        color=COLOURS.activation,
        alpha=0.35,
        markeredgewidth=0,
    )
    axes.set_ylim(0.0, 1.05)


def _laws(axes: Axes, replay: Replay, xs: np.ndarray, law: LawSettings) -> None:
    now = contact(replay.simulation, replay.simulation.sample())
    quantity = replay.simulation.settings.quantity
    title = tr(
        "what each law makes of the pull at t = {time} s: J$_d$q̇ [m/s] over the distance"
        if quantity.against
        else "what each law makes of the pull at t = {time} s: J$_d$q̇ [m/s] over the value",
        time=f"{replay.time:.2f}",
    )
    axes.set_title(in_symbols(title, quantity), pad=5.0)
    axes.axhline(0.0, color=INK, linewidth=0.8)
    colours = PALETTES["light"].laws
    for i, (name, each) in enumerate(all_laws(law).items()):
        own = name == law.law
        ys = [each.line_rate(d, now.pull, now.approach, now.square) for d in xs.tolist()]
        colour, label = colours[i % len(colours)], tr(LAWS[name].short)
        width, dash = 2.4 if own else 1.1, DASHES[i // len(colours)]
        axes.plot(
            xs, ys, color=colour, linestyle=dash, linewidth=width, label=label, zorder=3.0 if own else 2.0
        )
    largest = min(max(abs(now.pull), law.nominal_velocity, abs(now.approach), 0.08) * 1.3, LONGEST)
    axes.set_ylim(-largest, largest)
    axes.plot(
        [now.distance],
        [now.rate],
        marker="o",
        markersize=6.0,
        color=INK,
        linestyle="none",
        label=tr("now"),
        zorder=4.0,
    )
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), fontsize=8.5, borderaxespad=0.0)


def caption(run: RunSettings, own: LawAnswers | None = None) -> str:
    """One line about the run. `own`: custom law, or None."""
    law, begin = run.law, f"Duet {made_here()['duet']} · {page_value('scene', run.scene)}"
    if own is not None:
        begin += " · " + own.file.replace("$", r"\$")
    if own is not None or run.experiment.obstacle == "nothing":
        return f"{begin} · K = {run.gain:g}/s, dt = {1000.0 * run.dt:g} ms"
    of_law = (
        f"{page_value('law', law.law)} · d_m = {1000.0 * law.critical_distance:g} mm, n = {law.order:g}, "
        f"v = {law.nominal_velocity:g} m/s"
    )
    of_law, threshold = in_symbols(of_law, run.quantity), f"{run.quantity.symbol}_m"
    return (
        f"{begin} · {mathtext(of_law).replace(threshold, f'${threshold}$')}, K = {run.gain:g}/s, "
        f"dt = {1000.0 * run.dt:g} ms"
    )


def mathtext(html: str) -> str:
    """d<sub>m</sub> → d$_{m}$."""
    return re.sub(r"<sub>([^<]*)</sub>", r"$_{\\mathrm{\1}}$", html)
