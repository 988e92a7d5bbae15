"""Fig. 5: one arm holds its hand, a person moves the other."""

import numpy as np

from app.features.figures.drawn_figure import COLOURS, DASHES, Drawn, Plan, csv_head, stack, tag
from app.plots import time_series
from app.plots.time_plots import CEILING
from controllers.kinematics import Array
from scenes.headless import Run
from scenes.history import COLUMN

FELT = 0.05
"""Smallest λ that counts as avoidance."""

LONGEST = 0.5
"""Larger resting distances count as infinite [m]."""


def seconds(plan: Plan) -> float:
    """[s]; 50 s in the paper."""
    return plan.either(50.0, 12.0)


def resting_distances(run: Run) -> Array:
    """d* (rows,) [m]; nan if there is no rest below `LONGEST`."""
    rest = np.array(time_series.resting_rows(run.simulation.settings, run.table))
    return np.where(rest < LONGEST, rest, np.nan)


def draw(plan: Plan) -> Drawn:
    single = plan.settings({"pairs": "single"})
    length = seconds(plan)
    paper = plan.shared(single, length)
    ours = plan.shared(plan.settings({"pairs": "soft"}), length)
    time, d, e2 = (paper.table[:, COLUMN[name]] for name in ("t", "d", "e2"))
    rest = resting_distances(paper)
    figure, (upper, lower) = stack(4.0, 2)
    critical = single.law.critical_distance
    upper.plot(time, rest, color=COLOURS.resting, linestyle=DASHES[2], linewidth=1.2, label="$d^*$")
    upper.plot(time, d, color=COLOURS.distance, label="$d$")
    upper.axhline(critical, color=COLOURS.critical, linestyle=DASHES[4], linewidth=1.3, label="$d_m$")
    tag(upper, "$d_m$", 0.004 * length, critical - 0.028, COLOURS.critical, 12)
    upper.set(ylim=(0, CEILING), yticks=np.arange(0, CEILING + 0.01, 0.1), ylabel="distance [m]")
    upper.legend(
        handles=upper.lines[1::-1], loc="upper right", ncols=2, bbox_to_anchor=(1.0, 1.13), borderaxespad=0.0
    )
    lower.plot(time, e2, color=COLOURS.error)
    lower.set(xlim=(0, length), ylim=(0, None), ylabel="squared error $e^2$ [m²]", xlabel="time [s]")
    found = [
        kept(paper),
        f"The other hand comes with up to {1000 * approach(paper):.0f} mm/s; v = {1000 * single.law.nominal_velocity:.0f} mm/s.",
        f"The price is the error: e² up to {paper.summary.e2_max:.3f} m², that is {1000 * paper.summary.e2_max**0.5:.0f} mm.",
        f"The closest pair changes {switches(paper)} times while λ > {FELT:g}; the largest step of q̇ from one time step to the next is "
        f"{paper.summary.dq_step_max:.4f} rad/s. With the smooth minimum over all pairs (ours) it is "
        f"{ours.summary.dq_step_max:.4f} rad/s on the same input, with d ≥ {1000 * ours.summary.d_min:.1f} mm and "
        f"e² ≤ {ours.summary.e2_max:.3f} m². Whether such a step is a jump shows when dt is halved: see `switches`.",
    ]
    columns = ["t", "d", "d_rest", "lambda", "e2", "u", "w", "d_soft", "e2_soft"]
    picked = [paper.table[:, COLUMN[name]] for name in ("lambda", "e2", "u", "w")]
    soft = [ours.table[:, COLUMN[name]] for name in ("d", "e2")]
    rows = np.column_stack([time, d, rest, *picked, *soft]).tolist()
    return Drawn(figure, columns, rows, csv_head(single, seconds=length), found)


def kept(run: Run) -> str:
    critical = run.simulation.settings.law.critical_distance
    word = "never passes" if run.summary.d_min >= critical else "**passes**"
    return (
        f"The distance {word} d_m = {1000 * critical:.0f} mm: its minimum is {1000 * run.summary.d_min:.1f} mm, between "
        f"{run.summary.d_min_pair}."
    )


def switches(run: Run) -> int:
    """Changes of the closest pair during avoidance: far away two shoulders' pairs may alternate."""
    pair, lam = run.table[:, COLUMN["pair"]], run.table[:, COLUMN["lambda"]]
    return int(np.count_nonzero((np.diff(pair) != 0.0) & (lam[1:] > FELT)))


def approach(run: Run) -> float:
    """Largest w during avoidance [m/s]."""
    near = run.table[:, COLUMN["lambda"]] > 0.5
    return float(run.table[near, COLUMN["w"]].max()) if near.any() else 0.0
