"""The live plots: distance with d_m and d*, squared error, and a third one of choice; real time on x, the last 20 s."""

import math
from typing import Any, Final

import numpy as np
import viser
from viser import uplot

from app.page.buttons import ChoiceButtons
from app.page.theme import PALETTES, scale
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
            # Not every arm has seven joints.
            n = q.shape[1]
            b[9 : 9 + n], b[16 : 16 + n] = q[last], dq[last]

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


_PLOTS: Final[dict[str, tuple[str, tuple[int, ...], tuple[float, float] | None]]] = {
    "distance": ("distance d [m]", (1, 2, 3), (0.0, _CEILING)),
    "error": ("squared error e² [m²]", (4,), None),
    "lambda": ("activation λ", (5,), (0.0, 1.05)),
    "joints": ("joints q of the avoiding arm [°]", tuple(range(9, 16)), (-180.0, 180.0)),
    "rates": ("joint speeds q̇ of the avoiding arm [°/s]", tuple(range(16, 23)), None),
    "speeds": ("speeds along the line [m/s]", (6, 7, 8), None),
}
"""Name → title, columns of the buffer, span of the axis (None: as the data ask)."""


Line = tuple[str, str, float, tuple[float, ...]]
"""Label, colour, width [px at a desk], dashes."""


class Plots:
    """The panel of plots. A plot that is not wanted is hidden, never removed: viser's page complains of late news for what is gone.

    Args:
        gui: of whoever sees them.
        tab: where they are drawn.
        page: how they look.
        height: of one plot [CSS px].
    """

    def __init__(self, gui: viser.GuiApi, tab: viser.GuiTabHandle, page: PageSettings, height: int) -> None:
        self.buffer = PlotBuffer()
        self._gui, self._tab, self._height, self._page = gui, tab, height, page
        with tab:
            self._legend = gui.add_html("", order=0.0)
        self._plots: dict[str, viser.GuiUplotHandle] = {}
        self._shown: Details = "none"
        self._next = 0.0
        self._drawn: tuple[int, Details] | None = None
        self._add("distance")
        self._add("error")
        self._legend.content = self._legend_html()
        self.choose(page.details)

    def _lines(self, name: str) -> tuple[Line, ...]:
        p = PALETTES[self._page.theme]
        match name:
            case "distance":
                return (
                    ("d", p.distance, 2.2, ()),
                    ("d_m", p.critical, 1.6, (7.0, 5.0)),
                    ("d*", p.resting, 1.6, (2.0, 4.0)),
                )
            case "error":
                return (("e²", p.error, 2.2, ()),)
            case "lambda":
                return (("λ", p.activation, 2.2, ()),)
            case "speeds":
                return (("u", p.pull, 2.0, ()), ("v", p.velocity, 1.8, (7.0, 5.0)), ("w", p.approach, 2.0, (2.0, 4.0)))
            case _:
                return tuple((f"q{i + 1}", c, 1.6, ((), (7.0, 4.0), (2.0, 3.0))[i // 3]) for i, c in enumerate(p.joints))

    def _series(self, name: str) -> tuple[uplot.Series, ...]:
        k = scale(self._page.profile)
        return (
            uplot.Series(),
            *(
                uplot.Series(label=label, stroke=colour, width=width * k, points={"show": False}, dash=dash)
                for label, colour, width, dash in self._lines(name)
            ),
        )

    def _axes(self) -> tuple[uplot.Axis, ...]:
        k = scale(self._page.profile)
        ink, grid = ("#aeb8c2", "#333941") if self._page.theme == "dark" else ("#4b545e", "#e4e8ec")
        axis: dict[str, Any] = {
            "font": f'{round(11 * k)}px system-ui, "Segoe UI", Roboto, "Liberation Sans", sans-serif',
            "stroke": ink,
            "grid": {"stroke": grid, "width": 1},
            "ticks": {"size": 4, "stroke": grid},
        }
        return (
            uplot.Axis(**axis, size=round(24 * k), space=round(46 * k)),
            uplot.Axis(**axis, size=round(46 * k), space=round(28 * k)),
        )

    def _add(self, name: str) -> None:
        title, columns, span = _PLOTS[name]
        # Without a fixed span the axis follows the data, but never closer than to a hundredth: noise is not to look like a hill.
        soft = {"min": {"soft": 0.0, "mode": 1, "pad": 0.05}, "max": {"soft": 0.01, "mode": 1, "pad": 0.1}}
        with self._tab:
            self._plots[name] = self._gui.add_uplot(
                data=self.buffer.series(columns),
                series=self._series(name),
                title=title,
                height=self._height,
                scales={"x": uplot.Scale(time=False, auto=True), "y": uplot.Scale(range=span if span else soft)},
                axes=self._axes(),
                legend=uplot.Legend(show=False),
                cursor={"drag": {"x": False, "y": False}, "sync": {"key": "t"}},
                padding=(6, 12, 0, 0),
            )

    def dress(self, page: PageSettings) -> None:
        """Take on another theme or profile."""
        self._page = page
        for name, plot in self._plots.items():
            plot.series = self._series(name)
            plot.axes = self._axes()
        self._legend.content = self._legend_html()

    def choose(self, details: Details) -> None:
        """Show another third plot, or none."""
        if details == self._shown:
            return
        if self._shown in self._plots:
            self._plots[self._shown].visible = False
        if details in self._plots:
            self._plots[details].visible = True
        elif details != "none":
            self._add(details)
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
                for i, c in enumerate(PALETTES[self._page.theme].joints)
            ]
        three = " duet-three" if self._shown != "none" else ""
        return f'<div class="duet-plots duet-legend{three}">{"".join(parts)}</div>'

    def show(self, simulation: Simulation, now: float) -> None:
        """Take in the newest steps, and refresh the plots if there is news and it is time. `now`: wall time [s]."""
        self.buffer.feed(simulation)
        state = simulation.history.count, self._shown
        if now < self._next or state == self._drawn:
            return
        self._next, self._drawn = now + PERIOD, state
        for name, plot in self._plots.items():
            if name in ("distance", "error", self._shown):
                plot.data = self.buffer.series(_PLOTS[name][1], 180.0 / math.pi if name in ("joints", "rates") else 1.0)


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
