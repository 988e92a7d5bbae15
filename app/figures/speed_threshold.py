"""How near the arms come when the person gets faster: the threshold at w = v."""

from itertools import islice
from typing import Final

import numpy as np

from app.figures.drawn_figure import COLOURS, DASHES, Drawn, Plan, csv_head, sheet
from app.figures.fig5_hold import approach
from scenes.headless import Summary, run
from scenes.roles import Paced
from scenes.room import build_room
from scenes.settings import RunSettings
from scenes.two_arms import Autopilot

SCRIPT: Final = 46.0
"""Length of the person's script at its own pace [s]."""

LOOKS: Final = {
    False: ("o", COLOURS.distance, DASHES[0], "paper's law"),
    True: ("s", COLOURS.velocity, DASHES[1], "$w$ added to $v$"),
}
"""Whether the law knows w → marker, colour, dash and label."""


def _at_pace(settings: RunSettings, seconds: float, pace: float) -> tuple[float, Summary]:
    """Return w, and what a run comes to, with the person of the settings at another pace."""
    person = Autopilot(build_room(settings.rig), settings.guided, settings.seed)
    made = run(settings, seconds, Paced(person, pace))
    return approach(made), made.summary


def draw(plan: Plan) -> Drawn:
    paces = plan.either((0.4, 0.6, 0.8, 1.0, 1.2, 1.4, 1.5, 1.6, 1.7, 1.8, 2.0, 2.3, 2.7, 3.2, 3.8), (1.0, 3.8))
    base = plan.settings(rig="table", hand_speed=1.0)
    v, critical = base.law.nominal_velocity, base.law.critical_distance
    calls = [
        (plan.settings({"feed_forward": feed_forward}, rig="table", hand_speed=1.0), plan.either(SCRIPT, 20.0) / pace, pace)
        for feed_forward in LOOKS
        for pace in paces
    ]
    made = iter(plan.each(_at_pace, calls))
    results = {feed_forward: list(islice(made, len(paces))) for feed_forward in LOOKS}
    figure = sheet(3.1)
    axes = figure.subplots()
    for feed_forward, (marker, colour, dash, label) in LOOKS.items():
        runs = results[feed_forward]
        xs, ys = [v / w for w, _ in runs], [summary.d_min for _, summary in runs]
        axes.plot(xs, ys, marker=marker, color=colour, linestyle=dash, markersize=5, markeredgecolor="white", label=label)
    axes.axhline(critical, color=COLOURS.critical, linestyle=DASHES[4], linewidth=1.3)
    axes.axvline(1.0, color=COLOURS.approach, linestyle=DASHES[2], linewidth=1.3)
    axes.set(xscale="log", xlabel="$v/w$, retreat over the fastest approach", ylabel="smallest distance [m]", ylim=(0, 0.2))
    axes.set_yticks(np.arange(0, 0.21, 0.05))
    axes.set_xticks([0.4, 0.5, 0.7, 1, 1.5, 2, 3], ["0.4", "0.5", "0.7", "1", "1.5", "2", "3"], minor=False)
    axes.set_xticks([], minor=True)
    axes.text(0.985, 0.012, "$w>v$  ", color=COLOURS.approach, ha="right", fontsize=10.5)
    axes.text(1.015, 0.012, "  $w<v$", color=COLOURS.approach, ha="left", fontsize=10.5)
    axes.text(axes.get_xlim()[1], critical - 0.004, "$d_m$", color=COLOURS.critical, ha="right", va="top", fontsize=12)
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 0.12))
    paper, fed = results[False], results[True]
    kept = [summary.d_min for w, summary in paper if w <= v]
    lost = [(w, summary.d_min) for w, summary in paper if summary.d_min < critical]
    found = [
        f"Smallest distance of the {len(kept)} runs with w ≤ v: {1000 * min(kept):.1f} mm, d_m = {1000 * critical:.0f} mm."
        if kept
        else "",
        f"Above, it is lost at the rate w − v: d_m is first passed at w = {min(lost)[0]:.3f} m/s (v = {v:.2f} m/s), and at "
        f"w = {max(lost)[0]:.2f} m/s the arms come as near as {1000 * max(lost)[1]:.0f} mm. A short push somewhat faster than v still "
        "ends above d_m, since d* > d_m leaves a margin."
        if lost
        else "",
        f"With the approach added to v (ours) no run comes nearer than {1000 * min(summary.d_min for _, summary in fed):.1f} mm, "
        f"up to w = {max(w for w, _ in fed):.2f} m/s.",
    ]
    rows = [
        [int(feed), pace, w, v / w, summary.d_min, summary.share_below]
        for feed, runs in results.items()
        for pace, (w, summary) in zip(paces, runs, strict=True)
    ]
    assert np.isfinite([row[4] for row in rows]).all()
    columns = ["w_added", "pace", "w_max", "v_over_w", "d_min", "share_below"]
    return Drawn(figure, columns, rows, csv_head(base), [sentence for sentence in found if sentence])
