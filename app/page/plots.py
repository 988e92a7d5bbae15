"""The live plots: distance with d_m and d*, squared error, and a third one of choice; real time on x, the last 20 s."""

import math
from typing import Any, Final

import numpy as np
import viser
from viser import uplot

from app.page.buttons import ChoiceButtons
from app.page.theme import PALETTES, Palette, scale
from app.session import Session
from app.settings import Details, PageSettings
from controllers.budget import resting_distance
from controllers.kinematics import Array
from scenes.history import COLUMN
from scenes.settings import specs
from scenes.simulation import Simulation

WINDOW: Final = 20.0
"""Length of the time axis [s]."""

POINTS: Final = 160
"""Bins of the time axis. A bin keeps the smallest d and the largest e² in it, so that no dip between two points is lost."""

PERIOD: Final = 0.1
"""Wall time between two refreshes [s]."""

_CEILING: Final = 0.4
"""Top of the distance axis [m]: Fig. 5's."""


class PlotBuffer:
    """The last 20 s in bins: time, then d, d_m, d*, e², λ, u, v, w, and the avoiding arm's q and q̇ (7 + 7)."""

    COLUMNS: Final = 9 + 14

    def __init__(self) -> None:
        self._bins = np.full((POINTS, self.COLUMNS), np.nan)
        self._seen = 0
        self._last_bin = -1

    def clear(self) -> None:
        """Forget everything."""
        self._bins[:] = np.nan
        self._seen, self._last_bin = 0, -1

    def feed(self, simulation: Simulation) -> None:
        """Take in every step made since the last call."""
        history = simulation.history
        if history.count < self._seen:
            self.clear()
        if history.count == self._seen:
            return
        table = history.table(history.count - self._seen)
        self._seen = history.count
        joints, law = simulation.avoiding.joints, simulation.settings.law
        q, dq = history.positions(table)[:, joints], history.velocities(table)[:, joints]
        numbers = (table[:, COLUMN["t"]] * (POINTS / WINDOW)).astype(int)
        for number in np.unique(numbers).tolist():
            rows = np.flatnonzero(numbers == number)
            last = rows[-1]
            if number != self._last_bin:
                # A long step may jump over a bin; what is left in the ring from 20 s ago must go.
                first = max(self._last_bin + 1, number - POINTS + 1)
                for skipped in range(first, number + 1):
                    self._bins[skipped % POINTS] = np.nan
                self._last_bin = number
            b = self._bins[number % POINTS]
            d, e2 = float(table[rows, COLUMN["d"]].min()), float(table[rows, COLUMN["e2"]].max())
            u, w = float(table[last, COLUMN["u"]]), float(table[last, COLUMN["w_law"]])
            rest = resting_distance(law.critical_distance, law.order, law.nominal_velocity, u, w)
            b[0] = table[last, COLUMN["t"]]
            b[1] = d if not b[1] < d else b[1]
            b[2] = law.critical_distance
            # Nothing pulls the arms together: d* is infinite, and its line leaves the axis at the top.
            b[3] = min(rest, 2.0 * _CEILING) if law.law == "smooth_priority" else math.nan
            b[4] = e2 if not b[4] > e2 else b[4]
            b[5:9] = table[last, COLUMN["lambda"]], u, law.nominal_velocity, table[last, COLUMN["w"]]
            b[9:16], b[16:] = q[last], dq[last]

    def series(self, columns: tuple[int, ...], scale: float = 1.0) -> tuple[Array, ...]:
        """Return time and the columns asked for, oldest first, in equal lengths; columns times `scale`."""
        newest = self._last_bin
        order = np.arange(newest - POINTS + 1, newest + 1) % POINTS
        rows = self._bins[order]
        rows = rows[~np.isnan(rows[:, 0])]
        if len(rows) < 2:
            # uPlot needs an extent; nothing but an axis is drawn.
            end = 0.0 if not len(rows) else float(rows[-1, 0])
            return (np.array([end - 0.1, end]), *(np.full(2, np.nan) for _ in columns))
        return (rows[:, 0], *(rows[:, c] * scale for c in columns))


_CHOICES: Final[dict[Details, tuple[str, tuple[int, ...]]]] = {
    "none": ("", ()),
    "lambda": ("activation λ", (5,)),
    "joints": ("joints q of the avoiding arm [°]", tuple(range(9, 16))),
    "rates": ("joint speeds q̇ of the avoiding arm [°/s]", tuple(range(16, 23))),
    "speeds": ("speeds along the line [m/s]", (6, 7, 8)),
}


class Plots:
    """The panel of plots.

    Args:
        gui: of whoever sees them.
        tab: where they are drawn.
        page: how they look; a new theme or profile needs new plots.
        height: of one plot [CSS px].
    """

    def __init__(self, gui: viser.GuiApi, tab: viser.GuiTabHandle, page: PageSettings, height: int) -> None:
        self.buffer = PlotBuffer()
        self._tab = tab
        self._height = height
        self._gui, self._page = gui, page
        self._palette: Palette = PALETTES[page.theme]
        p = self._palette
        with tab:
            self._legend = gui.add_html("", order=0.0)
        self._distance = self._plot(
            "distance d [m]",
            (("d", p.distance, 2.2, ()), ("d_m", p.critical, 1.6, (7.0, 5.0)), ("d*", p.resting, 1.6, (2.0, 4.0))),
            (0.0, _CEILING),
        )
        self._error = self._plot("squared error e² [m²]", (("e²", p.error, 2.2, ()),), None)
        self._details: viser.GuiUplotHandle | None = None
        self._shown: Details = "none"
        self._next = 0.0
        self._legend.content = self._legend_html()
        self.choose(page.details)

    def _plot(
        self, title: str, lines: tuple[tuple[str, str, float, tuple[float, ...]], ...], span: tuple[float, float] | None
    ) -> viser.GuiUplotHandle:
        k = scale(self._page.profile)
        font = f'{round(11 * k)}px system-ui, "Segoe UI", Roboto, "Liberation Sans", sans-serif'
        dark = self._page.theme == "dark"
        ink, grid = ("#aeb8c2", "#333941") if dark else ("#4b545e", "#e4e8ec")
        axis: dict[str, Any] = {
            "font": font,
            "stroke": ink,
            "grid": {"stroke": grid, "width": 1},
            "ticks": {"size": 4, "stroke": grid},
        }
        series: list[uplot.Series] = [uplot.Series()]
        for label, colour, width, dash in lines:
            series.append(uplot.Series(label=label, stroke=colour, width=width * k, points={"show": False}, dash=dash))
        # Without a fixed span the axis follows the data, but never closer than to a hundredth: noise is not to look like a hill.
        soft = {"min": {"soft": 0.0, "mode": 1, "pad": 0.05}, "max": {"soft": 0.01, "mode": 1, "pad": 0.1}}
        y = uplot.Scale(range=span if span else soft)
        with self._tab:
            return self._gui.add_uplot(
                data=(np.array([0.0, 0.1]), *(np.full(2, np.nan) for _ in lines)),
                series=tuple(series),
                title=title,
                height=self._height,
                scales={"x": uplot.Scale(time=False, auto=True), "y": y},
                axes=(
                    uplot.Axis(**axis, size=round(24 * k), space=round(46 * k)),
                    uplot.Axis(**axis, size=round(46 * k), space=round(28 * k)),
                ),
                legend=uplot.Legend(show=False),
                cursor={"drag": {"x": False, "y": False}, "sync": {"key": "t"}},
                padding=(6, 12, 0, 0),
            )

    def choose(self, details: Details) -> None:
        """Show another third plot, or none."""
        if details == self._shown:
            return
        if self._details is not None:
            self._details.remove()
            self._details = None
        title, columns = _CHOICES[details]
        if columns:
            p = self._palette
            spans: dict[Details, tuple[float, float]] = {"lambda": (0.0, 1.05), "joints": (-180.0, 180.0)}
            lines = {
                "lambda": (("λ", p.activation, 2.2, ()),),
                "speeds": (("u", p.pull, 2.0, ()), ("v", p.velocity, 1.8, (7.0, 5.0)), ("w", p.approach, 2.0, (2.0, 4.0))),
            }.get(details) or tuple((f"q{i + 1}", c, 1.6, ((), (7.0, 4.0), (2.0, 3.0))[i // 3]) for i, c in enumerate(p.joints))
            self._details = self._plot(title, lines, spans.get(details))
        self._shown = details
        self._legend.content = self._legend_html()

    def _legend_html(self) -> str:
        parts = [
            '<span class="d"><i></i>d</span>',
            '<span class="dm"><i class="dash"></i>d<sub>m</sub></span>',
            '<span class="rest"><i class="dot"></i>d* resting distance</span>',
            '<span class="e"><i></i>e²</span>',
        ]
        if self._shown == "lambda":
            parts.append('<span class="lam"><i></i>λ</span>')
        elif self._shown == "speeds":
            parts += [
                '<span class="u"><i></i>u pull</span>',
                '<span class="v"><i class="dash"></i>v</span>',
                '<span class="w"><i class="dot"></i>w approach</span>',
            ]
        elif self._shown in ("joints", "rates"):
            kinds = ("", "dash", "dot")
            parts += [
                f'<span style="color:{c}"><i class="{kinds[i // 3]}"></i>{i + 1}</span>'
                for i, c in enumerate(self._palette.joints)
            ]
        three = " duet-three" if self._shown != "none" else ""
        return f'<div class="duet-plots duet-legend{three}">{"".join(parts)}</div>'

    def show(self, simulation: Simulation, now: float, force: bool = False) -> None:
        """Take in the newest steps, and refresh the plots if it is time. `now`: wall time [s]."""
        self.buffer.feed(simulation)
        if now < self._next and not force:
            return
        self._next = now + PERIOD
        self._distance.data = self.buffer.series((1, 2, 3))
        self._error.data = self.buffer.series((4,))
        if self._details is not None:
            columns = _CHOICES[self._shown][1]
            self._details.data = self.buffer.series(columns, 180.0 / math.pi if self._shown in ("joints", "rates") else 1.0)

    def remove(self) -> None:
        """Take the plots off the page."""
        for handle in (self._legend, self._distance, self._error, self._details):
            if handle is not None:
                handle.remove()


class DetailsChooser:
    """The row of buttons that chooses the third plot.

    Args:
        gui: of whoever operates it.
        session: whose plots.
        tab: of the panel of plots.
    """

    def __init__(self, gui: viser.GuiApi, session: Session, tab: viser.GuiTabHandle) -> None:
        spec = specs(PageSettings)["plot"]
        self._session, self._choices = session, spec.choices
        with tab:
            self._buttons = ChoiceButtons(
                gui,
                "more plots",
                spec.choice_labels,
                spec.help,
                lambda i: session.post(lambda: session.change("plot", spec.choices[i])),
                order=0.5,
            )

    def show(self) -> None:
        """Mark the present choice."""
        self._buttons.mark(self._choices.index(self._session.settings.page.details))
