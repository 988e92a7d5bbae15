"""Panel of plots."""

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
import viser
from markupsafe import Markup
from viser import uplot

from app.plots.bins import LAST, Bins, begin_of, polyline
from app.plots.chart_list import further_charts
from app.plots.lap_charts import laps_html
from app.plots.law_charts import curve_html, laws_html, laws_legend
from app.plots.pair_strips import pairs_html
from app.plots.plot_choice import cells, chart_title, is_chart, layout_html, makes_room, place_of
from app.plots.stability_text import section_html
from app.plots.ticked_laws import TickedLaws
from app.plots.time_plots import PlotLine, TimePlot, colour_of, time_plot_of
from app.plots.time_series import COLUMNS, RollingSeries, drawable
from app.session.frame import Frame
from app.settings import Details, PageSettings
from app.text.templates import element, macros, tr_html
from app.theme import PALETTES, PLOT_HEADROOM, scale
from controllers.kinematics import Array
from scenes.rerun import WhatIf
from scenes.simulation import Simulation

WHAT_IF: Final = ("d", "e2")

PERIOD: Final = 0.2
"""Time between two refreshes of a plot [s]."""

MOST_BYTES: Final = 50_000.0
"""Largest traffic of a plot [B/s], which limits its refreshes."""


CURTAIN: Final = 0.3
"""Time without plots after a change of theme [s]."""


_TICKS: Final = tuple(float(f"{digit}e{power}") for power in range(-3, 7) for digit in (1, 2, 5))
"""Tick distances without 0.0025, because the page writes three decimals."""


def _curves_beside(frame: Frame) -> WhatIf | None:
    """None for a replay."""
    found = (part.curves() for part in frame.live.parts or ()) if frame.of_live else ()
    return next((curves for curves in found if curves is not None), None)


class Plots:
    """Plots are hidden, never removed: viser's page warns of late updates of removed elements.

    Args:
        height: of one plot [CSS px].

    Attributes:
        only: plots in place of the first two, if any.
        run_names: of run and ghost in the legends; None for the usual ones.
        span: ends of the time axis [s]; None before the second step.
    """

    def __init__(self, gui: viser.GuiApi, tab: viser.GuiTabHandle, page: PageSettings, height: int) -> None:
        self._gui, self._tab, self._height, self._page = gui, tab, height, page
        self.buffer, self._ghost_buffer = RollingSeries(), RollingSeries()
        self._what_if: WhatIf | None = None
        self._curves = Bins(len(WHAT_IF))
        with tab:
            self._layout = gui.add_html("", order=0.0)
        self._captions: dict[str, viser.GuiHtmlHandle] = {}
        self._charts: dict[str, viser.GuiHtmlHandle] = {}
        self._time_plots: dict[str, tuple[TimePlot, viser.GuiUplotHandle]] = {}
        self.shown: tuple[str, ...] = ()
        self.only: tuple[str, ...] = ()
        self.run_names: tuple[str, str] | None = None
        self._arranged: tuple[object, ...] = ()
        self._ticked: Mapping[str, int] = {}
        self._next: dict[str, float] = {}
        self._drawn: dict[str, object] = {}
        self._dressed, self._curtain = False, 0.0
        self.span: tuple[float, float] | None = None

    def dress(self, page: PageSettings, height: int) -> None:
        self._page, self._height, self._dressed = page, height, True
        self._drawn.clear()
        for time_plot, plot in self._time_plots.values():
            plot.height = height
            plot.series = self._series(time_plot)
            plot.axes = self._axes()
            plot.padding = self._padding()

    def show(self, frame: Frame) -> None:
        simulation, now = frame.simulation, frame.now
        traced, ghost = frame.traced
        self._take(_curves_beside(frame))
        self._arrange(traced, ghost, frame.settings.page.details)
        if self._dressed:
            # The page replaces every plot; new data at the same moment would leave a wrongly scaled time axis
            # for good. A plot that was hidden meanwhile is drawn from the start.
            self._dressed, self._curtain = False, now + CURTAIN
            self._next = dict.fromkeys(self.shown, self._curtain)
            self._uncover(False)
        elif 0.0 < self._curtain <= now:
            self._curtain = 0.0
            self._uncover(True)
        part = frame.part(TickedLaws)
        if (ticked := {} if part is None else part.places) != self._ticked:
            # A tick shows at once.
            self._ticked = ticked
            self._drawn.pop("laws", None)
            self._next.pop("laws", None)
        due = [name for name in self.shown if now >= self._next.get(name, 0.0)]
        if not due:
            return
        self.buffer.feed(traced)
        if ghost is not None:
            self._ghost_buffer.feed(ghost)
        state = traced.history, traced.history.count, traced.settings, ghost is not None, self._curves
        moment = simulation.history, simulation.history.count
        numbers = self.buffer.bins.numbers
        self.span = (
            (begin_of(numbers[0]), float(self.buffer.bins.ends(numbers)[-1])) if len(numbers) > 1 else None
        )
        for name in due:
            drawn: tuple[object, ...] = (*state, moment) if is_chart(name) else state
            if name in further_charts():
                drawn = (*drawn, further_charts()[name].state(frame))
            if self._drawn.get(name) == drawn:
                continue
            self._drawn[name] = drawn
            if is_chart(name):
                self._next[name] = frame.after(PERIOD)
                self._charts[name].content = self._chart_html(name, frame)
            else:
                time_plot, plot = self._time_plots[name]
                data = self._data(time_plot, ghost is not None)
                self._next[name] = frame.after(max(PERIOD, sum(line.nbytes for line in data) / MOST_BYTES))
                plot.data = data

    def _uncover(self, visible: bool) -> None:
        for name in self.shown:
            if name in self._time_plots:
                self._handle(name).visible = visible

    def _arrange(self, simulation: Simulation, ghost: Simulation | None, details: Details) -> None:
        arranged = (
            simulation.settings,
            simulation.law,
            ghost is not None,
            details,
            self.only,
            self.run_names,
            self._curves,
        )
        if arranged == self._arranged:
            return
        self._arranged = arranged
        wanted = cells(simulation.settings, details, self.only)
        if wanted != self.shown:
            for name in self.shown:
                if name not in wanted:
                    self._captions[name].visible = self._handle(name).visible = False
            for name in wanted:
                if name not in self._captions:
                    self._make(name, simulation)
                self._captions[name].visible = self._handle(name).visible = True
            self.shown = wanted
            self._layout.content = layout_html(wanted)
            self._drawn.clear()
        for name, (old, plot) in list(self._time_plots.items()):
            # The experiment may ask for other names.
            if (new := time_plot_of(name, simulation)) != old:
                self._time_plots[name] = new, plot
                self._drawn.pop(name, None)
        for name in wanted:
            self._captions[name].content = self._caption(name, simulation, ghost)

    def _handle(self, name: str) -> viser.GuiHtmlHandle | viser.GuiUplotHandle:
        return self._charts[name] if is_chart(name) else self._time_plots[name][1]

    def _make(self, name: str, simulation: Simulation) -> None:
        # Captions and plots alternate: in columns side by side on a desk, one below the other on a phone.
        order = 2.0 + 2.0 * place_of(name)
        with self._tab:
            self._captions[name] = self._gui.add_html("", order=order)
            if is_chart(name):
                self._charts[name] = self._gui.add_html("", order=order + 0.5)
                return
            time_plot = time_plot_of(name, simulation)
            # Without a fixed span the axis follows the data.
            soft: dict[str, Any] = {
                "min": {"pad": 0.1},
                "max": {"soft": time_plot.top, "mode": 1, "pad": 0.1},
            }
            if time_plot.positive:
                soft["min"] = {"soft": 0.0, "mode": 1, "pad": 0.05}
            nothing = np.full(2, np.nan)
            handle = self._gui.add_uplot(
                data=(np.array([0.0, 1.0]), *(nothing for _ in time_plot.lines)),
                series=self._series(time_plot),
                height=self._height,
                scales={
                    "x": uplot.Scale(time=False, auto=True),
                    "y": uplot.Scale(range=time_plot.span or soft),
                },
                axes=self._axes(),
                legend=uplot.Legend(show=False),
                cursor={"drag": {"x": False, "y": False}, "sync": {"key": "t"}},
                padding=self._padding(),
                order=order + 0.5,
            )
            self._time_plots[name] = time_plot, handle

    def _take(self, what_if: WhatIf | None) -> None:
        if what_if is not self._what_if:
            self._what_if, self._curves = what_if, Bins(len(WHAT_IF))
            if what_if is not None:
                self._curves.take(what_if.times, np.column_stack([what_if.distance, what_if.squared_error]))

    def _data(self, time_plot: TimePlot, with_ghost: bool) -> tuple[Array, ...]:
        """Time and all lines; an empty array for a line without values."""
        follows = time_plot.span is None
        times, found = self._lines(time_plot, with_ghost)
        lines = [drawable(line, follows) for line in found]
        if follows and not any(len(line) for line in lines):
            # A single point is not drawn, but it keeps the axis.
            lines[0] = np.full(len(times), np.nan)
            lines[0][0] = 0.0
        return times, *lines

    def _lines(self, time_plot: TimePlot, with_ghost: bool) -> tuple[Array, list[Array]]:
        numbers = self.buffer.bins.numbers
        if len(numbers) < 2:
            # uPlot needs an extent; only the axes of the next second are drawn.
            begin = float(self.buffer.bins.ends(numbers)[0]) if len(numbers) else 0.0
            return np.array([begin, begin + 1.0]), [np.full(2, np.nan) for _ in time_plot.lines]
        found: dict[int, Array] = {}
        for run, bins in (
            ("own", self.buffer.bins),
            ("ghost", self._ghost_buffer.bins),
            ("what_if", self._curves),
        ):
            places = [i for i, line in enumerate(time_plot.lines) if line.run == run]
            if (
                not places
                or (run == "ghost" and not with_ghost)
                or (run == "what_if" and self._what_if is None)
            ):
                continue
            columns = [COLUMNS[time_plot.lines[i].column] for i in places]
            # Before it begins, the other run was the visitor's own.
            own = None if run == "own" else self.buffer.bins.at(numbers, columns)
            if run == "what_if":
                columns = [WHAT_IF.index(time_plot.lines[i].column) for i in places]
            stats = bins.at(numbers, columns, own)
            found |= {place: stats[:, i] for i, place in enumerate(places)}
        # A line without known values has no corners.
        found = {place: one for place, one in found.items() if not np.isnan(one[LAST]).all()} or found
        stats = np.stack(list(found.values()), axis=1)
        times, values = polyline(numbers, self.buffer.bins.ends(numbers), stats, time_plot.visible(stats))
        # All plots over time begin with the oldest bin, so that a moment is at the same place on each.
        times, values = np.append(begin_of(numbers[0]), times), np.hstack([values[:, :1], values])
        shown = dict(zip(found, values * time_plot.scale, strict=True))
        return times, [shown.get(i, np.empty(0)) for i in range(len(time_plot.lines))]

    def _chart_html(self, name: str, frame: Frame) -> Markup:
        simulation, ghost, sample = frame.simulation, frame.ghost, frame.sample
        if name in further_charts():
            return Markup(further_charts()[name].draw(frame, self._height))
        match name:
            case "curve":
                return element("div", "", curve_html(simulation, ghost, sample, self._height), class_="duet")
            case "laws":
                return laws_html(simulation, ghost, frame.contact, self._height, self._ticked)
            case "laps" | "joint_laps":
                return laps_html(simulation, ghost, name == "joint_laps", self._height)
            case "pairs":
                return pairs_html(simulation, self.buffer)
            case _:
                return section_html(simulation, sample, frame.contact)

    def _series(self, time_plot: TimePlot) -> tuple[uplot.Series, ...]:
        return (uplot.Series(), *(self._line(line) for line in time_plot.lines))

    def _line(self, line: PlotLine) -> uplot.Series:
        width = line.width * scale(self._page.profile)
        colour = colour_of(line, PALETTES[self._page.theme])
        return uplot.Series(
            label=line.column,
            stroke=colour,
            width=width,
            points={"show": False},
            dash=line.dash,
            auto=line.held,
        )

    def _axes(self) -> tuple[uplot.Axis, ...]:
        k = scale(self._page.profile)
        ink, grid = PALETTES[self._page.theme].dim, PALETTES[self._page.theme].hair
        axis: dict[str, Any] = {
            "font": f'{round(11 * k)}px system-ui, "Segoe UI", Roboto, "Liberation Sans", sans-serif',
            "stroke": ink,
            "grid": {"stroke": grid, "width": 1},
            "ticks": {"size": 4, "stroke": grid},
        }
        return (
            uplot.Axis(**axis, size=round(24 * k), space=round(46 * k)),
            uplot.Axis(**axis, size=round(46 * k), space=round(28 * k), incrs=_TICKS),
        )

    def _padding(self) -> tuple[int, int, int, int]:
        """Top, right, bottom and left [CSS px]."""
        return round(PLOT_HEADROOM * scale(self._page.profile)), 12, 0, 0

    def _caption(self, name: str, simulation: Simulation, ghost: Simulation | None) -> Markup:
        # On a narrow screen the squared error makes room for the chosen plots.
        caption, spare = macros("plots/charts.html").caption, name == "error" and makes_room(self.shown)
        first = name == self.shown[0]
        if is_chart(name):
            lines = laws_legend(simulation) if name == "laws" else ()
            return caption(chart_title(name, simulation.settings), "", lines, spare, first)
        plot, _ = self._time_plots[name]
        others = [] if ghost is None else ["ghost"]
        if self._what_if is not None:
            others.append("what_if")
        lines = [
            (symbol, kind, tr_html(label)) for symbol, kind, label in plot.legend(others, self.run_names)
        ]
        return caption(tr_html(plot.title), plot.unit, lines, spare, first)
