"""The resting distance over n, v and w: closed form, and the whole loop."""

from typing import Final

import numpy as np

from app.figures.contact_run import Rest, rest
from app.figures.drawn_figure import Drawn
from app.figures.figure_style import COLOURS, DASHES, sheet
from app.figures.run_plan import Plan
from controllers import budget
from controllers.laws.smooth_priority import SmoothPriority

CRITICAL_DISTANCE: Final = 0.15
ORDER: Final = 2.0
VELOCITY: Final = 0.3
PULL: Final = 0.2
"""d_m [m], n, v and u [m/s] where they are not on the axis, as in the worked example of the closed form."""


def closed_form(n: float, v: float, w: float) -> float:
    """Return d* [m]; nan where there is none."""
    return budget.resting_distance(CRITICAL_DISTANCE, n, v, PULL, w)


def draw(plan: Plan) -> Drawn:
    sweeps = {
        "n": (np.linspace(1, 20, 200), plan.either((1, 2, 3, 4, 6, 8, 10, 14, 20), (4, 10)), "order $n$", (1, 20)),
        "v": (np.linspace(0.02, 0.6, 200), plan.either((0.05, 0.1, 0.2, 0.3, 0.4, 0.5), (0.1, 0.3)), "speed $v$ [m/s]", (0, 0.6)),
        "w": (
            np.linspace(0, 0.3, 200),
            plan.either((0.0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3), (0.1, 0.3)),
            "approach $w$ [m/s]",
            (0, 0.4),
        ),
    }
    figure = sheet(2.75)
    panels = figure.subplots(1, 3, sharey=True)
    rows: list[list[object]] = []
    for axes, (over, (grid, dots, label, span)) in zip(panels, sweeps.items(), strict=True):
        point = {"n": ORDER, "v": VELOCITY, "w": 0.0}
        line = [closed_form(**(point | {over: float(x)})) for x in grid]
        axes.plot(grid, line, color=COLOURS.resting, linestyle=DASHES[0])
        found = [_measured(**(point | {over: float(x)})) for x in dots]
        axes.plot(
            dots,
            [r.measured for r in found],
            "o",
            color=COLOURS.distance,
            markersize=5,
            markeredgecolor="white",
            clip_on=False,
            zorder=3,
        )
        axes.axhline(CRITICAL_DISTANCE, color=COLOURS.critical, linestyle=DASHES[4], linewidth=1.3)
        axes.set(xlabel=label, xlim=span, ylim=(0.1, 0.4))
        rows += [[over, float(x), r.closed_form, r.measured] for x, r in zip(dots, found, strict=True)]
    panels[0].set(ylabel="resting distance $d^*$ [m]", xticks=(1, 10, 20))
    panels[0].text(19.6, CRITICAL_DISTANCE - 0.012, "$d_m$", color=COLOURS.critical, fontsize=12, ha="right", va="top")
    panels[1].set(xticks=(0, 0.3, 0.6))
    panels[2].set(xticks=(0, 0.2, 0.4))
    panels[2].axvspan(VELOCITY, 0.4, color=COLOURS.approach, alpha=0.1, linewidth=0)
    panels[2].text(0.35, 0.25, "no rest:\n$w>v$", color=COLOURS.approach, ha="center", va="center", rotation=90, fontsize=9.5)
    worst = max(abs(float(r[2]) - float(r[3])) for r in rows)  # pyright: ignore[reportArgumentType]
    sentences = [
        "d* = d_m [(u + v)/(u + w)]^(1/n). "
        + ", ".join(f"{1000 * closed_form(n, VELOCITY, 0.0):.1f} mm (n = {n})" for n in (1, 2, 10))
        + f" for d_m = 150 mm, v = {VELOCITY}, u = {PULL} m/s and an obstacle that stands still.",
        f"The whole loop (two arms, hand against forearm, dt = 5 ms) comes to rest within {1000 * worst:.2f} mm of it in all "
        f"{len(rows)} runs.",
        "A larger n or w brings the rest nearer to d_m, a larger v farther away; w = v is the last that has one, and it is d_m.",
    ]
    settings = {"dm": CRITICAL_DISTANCE, "n": ORDER, "v": VELOCITY, "u": PULL, "w": 0.0, "dt": 0.005}
    return Drawn(figure, ["over", "value", "d_rest_closed_form", "d_rest_measured"], rows, settings, sentences)


def _measured(n: float, v: float, w: float) -> Rest:
    return rest(SmoothPriority(CRITICAL_DISTANCE, n, v), PULL, w)
