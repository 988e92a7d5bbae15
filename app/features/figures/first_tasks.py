"""Any first task: h with and without the law, and ḣ against the closed form.

The law (32) gets h, its row J_a and w, so that ḣ = λ v − (1 − λ) u − w holds for each, in its unit.
"""

from dataclasses import replace
from typing import Final

import numpy as np
from matplotlib.axes import Axes

from app.features.figures.drawn_figure import COLOURS, DASHES, Drawn, Plan, sheet
from app.features.figures.first_task_runs import (
    CART_HALF,
    CART_MASS,
    CASES,
    GAIN,
    LOAD,
    ORDER,
    SPEED,
    STEP,
    WALL_SPEED,
    FirstTaskCase,
    FirstTaskRun,
    Moment,
)
from controllers.first_tasks.first_task import FirstTask

COLUMNS: Final = (
    "quantity",
    "unit",
    "law",
    "t",
    "h",
    "h_m",
    "v",
    "lambda",
    "u",
    "w",
    "rate",
    "rate_closed_form",
    "exact",
)


def draw(plan: Plan) -> Drawn:
    figure = sheet(1.4 * len(CASES) + 0.6, 7.0)
    panels = figure.subplots(len(CASES), 2, width_ratios=(2.1, 1.0), squeeze=False)
    rows: list[list[object]] = []
    found: list[str] = []
    for case, (left, right) in zip(CASES, panels, strict=True):
        case = replace(case, places=plan.either(case.places, case.places[:1]))
        # The same person for both runs.
        made = [FirstTaskRun(case, law, plan.seed) for law in (False, True)]
        runs, task = [run.moments() for run in made], made[0].task
        for law, moments in enumerate(runs):
            rows += [_row(case, task, law, m) for m in moments]
        _draw_values(left, case, task, runs)
        _draw_rates(right, task, runs[1])
        found.append(_sentence(case, task, runs))
    panels[-1][0].set(xlabel="time [s]")
    panels[-1][1].set(xlabel=r"$\lambda v-(1-\lambda)u-w$")
    figure.align_ylabels()
    figure.legend(*panels[0][0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    found.append(
        "The law is the same in all rows. It is given h, J_a and w, and does not know what they are of. v is a rate in the unit of h: "
        "rad/s for the joint stops. Only the wall moves by itself; for the others w = 0."
    )
    settings = {
        "robot": "lwr",
        "n": ORDER,
        "gain": GAIN,
        "dt": STEP,
        "speed": SPEED,
        "seed": plan.seed,
        "wall_speed": WALL_SPEED,
        "cart_half": CART_HALF,
        "cart_mass": CART_MASS,
        "load": LOAD,
    }
    return Drawn(figure, COLUMNS, rows, settings, found)


def _row(case: FirstTaskCase, task: FirstTask, law: int, m: Moment) -> list[object]:
    thresholds = task.critical_value, task.nominal_rate
    return [
        *(case.name, task.unit, law, m.time, m.margin.value, *thresholds),
        *(m.lam, m.u, m.margin.approach, m.rate, m.closed_form, int(m.exact)),
    ]


def _draw_values(axes: Axes, case: FirstTaskCase, task: FirstTask, runs: list[list[Moment]]) -> None:
    looks = (
        {"color": COLOURS.approach, "linestyle": DASHES[1], "label": "without the law"},
        {"color": COLOURS.distance, "linestyle": DASHES[0], "label": "with it"},
    )
    axes.axhline(
        task.critical_value, color=COLOURS.critical, linestyle=DASHES[4], linewidth=1.3, label="$h_m$"
    )
    axes.axhline(0.0, color=COLOURS.faint, linewidth=0.8)
    for moments, look in zip(runs, looks, strict=True):
        axes.plot([m.time for m in moments], [m.margin.value for m in moments], **look)
    axes.set(title=case.title, ylabel=f"$h$ [{task.unit}]", xlim=(0, runs[0][-1].time))


def _draw_rates(axes: Axes, task: FirstTask, moments: list[Moment]) -> None:
    exact = [m for m in moments if m.exact]
    ends = [f([m.closed_form for m in exact]) for f in (min, max)]
    axes.plot(ends, ends, color=COLOURS.critical, linewidth=1.2)
    axes.plot(
        [m.closed_form for m in exact],
        [m.rate for m in exact],
        "o",
        color=COLOURS.activation,
        markersize=3.2,
        markeredgewidth=0,
    )
    axes.set(ylabel=f"$\\dot h$ [{task.unit}/s]")


def _sentence(case: FirstTaskCase, task: FirstTask, runs: list[list[Moment]]) -> str:
    least = [min(m.margin.value for m in moments) for moments in runs]
    exact = [m for m in runs[1] if m.exact]
    worst = float(np.max([abs(m.rate - m.closed_form) for m in exact]))
    return (
        f"{case.title.capitalize()}: least h {least[0]:.3f} {task.unit} without the law, {least[1]:.3f} with it "
        f"(h_m = {task.critical_value:g}, v = {task.nominal_rate:g} {task.unit}/s); ḣ within {worst:.0e} {task.unit}/s of "
        f"λ v − (1 − λ) u − w at {len(exact)} moments."
    )
