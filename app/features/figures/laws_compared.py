"""All laws on the same input at several time steps."""

import math
from collections.abc import Sequence
from itertools import islice
from typing import Any, Final, NamedTuple

import numpy as np
from matplotlib.axes import Axes

from app.features.figures.drawn_figure import COLOURS, DASHES, MARKERS, SERIES, Drawn, Plan, csv_head, sheet
from controllers.laws.situation import AUTHORITY
from controllers.laws.task_space import free_part
from controllers.tasks import TASK_DIMENSION
from scenes.headless import Run, Summary, run
from scenes.history import COLUMN
from scenes.laws import LAWS
from scenes.settings import RunSettings

TOLERANCE: Final = 2e-4
"""Tolerance of d_m [m]: a law that rests on it overshoots by a part of dt."""

JUMPS: Final = 0.4
"""A larger p of q̈ ∝ dt^−p is a jump (1 for a jump of q̇, 0 for a continuous q̇)."""

FAST: Final = 10.0
"""A law with a larger q̈, in multiples of the paper's law's, is fast."""

SLIDE: Final = 0.01
"""Movement of the closest points per step that counts as sliding [m]."""


class Jump(NamedTuple):
    """Step in which a law's velocity changes most.

    Attributes:
        time: [s].
        distance: d [m].
        activation: change of λ.
        lever, left: smaller |J_d| and |J_d N| of both steps, N: null space of the hand's task [m/rad].
        slide: movement of the pair's closest points [m].
    """

    time: float
    distance: float
    activation: float
    lever: float
    left: float
    slide: float
    pair: tuple[str, str]


def largest_jump(run: Run) -> Jump:
    simulation, settings, table = run.simulation, run.simulation.settings, run.table
    arm, kinematics, detector = simulation.avoiding, simulation.kinematics, simulation.detector
    steps = np.abs(np.diff(simulation.history.velocities(table)[:, arm.joints], axis=0)).max(1)
    after = int(steps.argmax()) + 1
    pair = int(table[after, COLUMN["pair"]])
    levers, left, points = list[float](), list[float](), list[np.ndarray]()
    for positions in simulation.history.positions(table[after - 1 : after + 1]):
        kinematics.update(np.ascontiguousarray(positions))
        row = detector.detect(*settings.law.proximity).row[arm.joints]
        levers.append(float(np.linalg.norm(row)))
        left.append(
            float(
                np.linalg.norm(free_part(row, kinematics.hand_jacobian(arm)[: TASK_DIMENSION[settings.task]]))
            )
        )
        points.append(np.array(detector.witness_points(pair)))
    return Jump(
        float(table[after, 0]),
        float(table[after, COLUMN["d"]]),
        abs(float(table[after, COLUMN["lambda"]] - table[after - 1, COLUMN["lambda"]])),
        min(levers),
        min(left),
        float(np.linalg.norm(points[1] - points[0], axis=1).max()),
        detector.pair_names[pair],
    )


def cause(label: str, jump: Jump, hand_first: bool) -> str:
    """Cause of a largest step with q̈ that grows as dt shrinks.

    `hand_first`: True if the law moves in the null space.
    """
    here = f"{label}: the largest q̈ is at t = {jump.time:.2f} s, d = {jump.distance:.3f} m."
    if jump.activation > 0.5:
        return f"{here} There λ jumps by {jump.activation:.0f}: it is the law that jumps."
    lever = jump.left if hand_first else jump.lever
    if lever >= AUTHORITY:
        return f"{here} |J_d| = {jump.lever:.2f} m/rad there, and λ changes by {jump.activation:.2g}."
    singular = (
        f"of |J_d| = {jump.lever:.2f} m/rad the hand leaves |J_d N| = {jump.left:.3f} m/rad"
        if hand_first
        else f"J_d is singular, |J_d| = {jump.lever:.3f} m/rad"
    )
    said = f"{here} The law itself does not jump: {singular}, and dividing by that turns a small change of J_d into a large one of q̇."
    if jump.slide < SLIDE:
        return said
    first, second = jump.pair
    return (
        f"{said} J_d jumps because the closest points of {first} and {second} slide by {1000 * jump.slide:.0f} mm along their bodies in "
        "one step, as on two capsules that are parallel for a moment."
    )


def variants() -> dict[str, dict[str, Any]]:
    found: dict[str, dict[str, Any]] = {}
    for name, law in LAWS.items():
        found[law.label.replace("d_m", "$d_m$")] = {"law": name}
        if law.has_barrier:
            # A barrier function needs the obstacle's speed.
            found[f"{law.short} with $w$"] = {"law": name, "feed_forward": True}
    return found


def _run_with_jump(settings: RunSettings, seconds: float) -> tuple[Summary, Jump]:
    made = run(settings, seconds)
    return made.summary, largest_jump(made)


def draw(plan: Plan) -> Drawn:
    steps = plan.either((0.02, 0.01, 0.005, 0.0025), (0.02, 0.01))
    length = plan.either(46.0, 12.0)
    base = plan.settings(rig="table")
    laws = variants()
    settings = [plan.settings(law, rig="table", dt=dt) for law in laws.values() for dt in steps]
    made = iter(plan.each(_run_with_jump, [(each, length) for each in settings]))
    runs: dict[str, list[Summary]] = {}
    jumps: list[str] = []
    for label, law in laws.items():
        found = list(islice(made, len(steps)))
        runs[label] = [summary for summary, _ in found]
        if growth(runs[label], steps) > JUMPS:
            jumps.append(cause(label.replace("$", ""), found[-1][1], LAWS[law["law"]].in_null_space))
    figure = sheet(6.0, 10.4)
    layout: list[Any] = [["d", "d zoom", "table"], ["e", "e zoom", "table"], ["a", "a", "table"]]
    panels = figure.subplot_mosaic(layout, width_ratios=(1.0, 1.0, 1.75))
    figure.align_ylabels()
    ticks = [1000.0 * dt for dt in steps]
    for i, (label, summaries) in enumerate(runs.items()):
        # A logarithmic axis cannot show a law that never moves the arm.
        fastest = [s.ddq_max or math.nan for s in summaries]
        lines = {"d": [s.d_min for s in summaries], "e": [s.e2_max for s in summaries], "a": fastest}
        for name, values in lines.items():
            for axes in (panels[key] for key in (name, f"{name} zoom") if key in panels):
                axes.plot(ticks, values, label=label, **_style(i))
    critical = base.law.critical_distance
    for name in ("d", "d zoom"):
        panels[name].axhline(critical, color=COLOURS.critical, linestyle=DASHES[4], linewidth=1.2)
    panels["d"].set(ylabel=r"smallest $d$ [m]")
    panels["d zoom"].set(ylim=(critical - 0.05, critical + 0.05), title="around $d_m$")
    panels["e"].set(ylabel=r"largest $e^2$ [m²]", ylim=(0, None))
    panels["e zoom"].set(ylim=_middle([s[-1].e2_max for s in runs.values()]), title="where most are")
    panels["a"].set(ylabel=r"largest $\ddot q$ [rad/s²]", yscale="log")
    for name in ("d", "d zoom", "e", "e zoom", "a"):
        axes = panels[name]
        axes.set_xscale("log")
        axes.set_xticks(ticks, [f"{dt:g}" for dt in ticks], minor=False)
        axes.set_xticks([], minor=True)
        axes.set_xlabel("time step [ms]" if name == "a" else "")
    _table(panels["table"], runs, steps)
    rows = [
        [
            law["law"],
            int("feed_forward" in law),
            dt,
            s.d_min,
            s.share_below,
            s.e2_max,
            s.dq_step_max,
            s.ddq_max,
            s.pair_switches,
        ]
        for law, summaries in zip(laws.values(), runs.values(), strict=True)
        for dt, s in zip(steps, summaries, strict=True)
    ]
    columns = [
        "law",
        "w_added",
        "dt",
        "d_min",
        "share_below",
        "e2_max",
        "dq_step_max",
        "ddq_max",
        "pair_switches",
    ]
    settings = csv_head(base, "law", "ff", "dt", seconds=length)
    return Drawn(figure, columns, rows, settings, _found(runs, steps, base.law.critical_distance, jumps))


def _style(i: int) -> dict[str, Any]:
    return {
        "marker": MARKERS[i % len(MARKERS)],
        "color": SERIES[i % len(SERIES)],
        "linestyle": DASHES[i % len(DASHES)],
        "markersize": 6.0,
        "markeredgecolor": "white",
        "markeredgewidth": 0.6,
        "linewidth": 1.5,
    }


def _middle(values: list[float]) -> tuple[float, float]:
    low, high = np.percentile(values, (25, 75)).tolist()
    low, high = min(low, values[0]), max(high, values[0])
    margin = 0.25 * (high - low) + 1e-3
    return max(0.0, low - margin), high + margin


def _table(axes: Axes, runs: dict[str, list[Summary]], steps: Sequence[float]) -> None:
    axes.axis("off")
    axes.set(xlim=(0, 1), ylim=(len(runs) + 0.3, -1.3))
    places = (0.66, 0.78, 0.9, 1.0)
    for x, text in zip(places, ("$d$ [mm]", "$e^2$ [m²]", r"$\ddot q$", "$p$"), strict=True):
        axes.text(x, -0.6, text, ha="right", va="center", fontsize=9.0)
    axes.text(0.1, -0.6, f"at dt = {1000 * steps[-1]:g} ms", va="center", fontsize=9.0)
    for i, (label, summaries) in enumerate(runs.items()):
        last = summaries[-1]
        axes.plot([0.0, 0.04, 0.08], [i] * 3, markevery=[1], **_style(i))
        axes.text(0.1, i, label, va="center", fontsize=9.0)
        numbers = (
            f"{1000 * last.d_min:.0f}",
            f"{last.e2_max:.3f}",
            f"{last.ddq_max:.3g}",
            f"{growth(summaries, steps) + 0.0:.2f}",
        )
        for x, text in zip(places, numbers, strict=True):
            axes.text(x, i, text, ha="right", va="center", fontsize=9.0)


def growth(runs: Sequence[Summary], steps: Sequence[float]) -> float:
    """p of q̈ ∝ dt^−p between the largest and smallest step; 0 if the arm never moves."""
    if not runs[0].ddq_max:
        return 0.0
    return math.log(runs[-1].ddq_max / runs[0].ddq_max) / math.log(steps[0] / steps[-1])


def _found(
    runs: dict[str, list[Summary]], steps: Sequence[float], critical: float, jumps: list[str]
) -> list[str]:
    lines = [
        "| law | d_min [mm] | time below d_m | e²_max [m²] | max q̈ [rad/s²] | p in q̈ ∝ dt^−p |",
        "|---|---|---|---|---|---|",
    ]
    plain = {label.replace("$", ""): summaries for label, summaries in runs.items()}
    for label, summaries in plain.items():
        last, p = summaries[-1], round(growth(summaries, steps), 2) + 0.0
        word = f"{p:.2f}, see below" if p > JUMPS else f"{p:.2f}"
        lines.append(
            f"| {label} | {1000 * last.d_min:.1f} | {100 * last.share_below:.0f} % | {last.e2_max:.3f} | {last.ddq_max:.3g} | {word} |"
        )
    keep = [label for label, s in plain.items() if min(x.d_min for x in s) >= critical - TOLERANCE]
    return [
        "\n".join(lines),
        f"In the table dt = {1000 * steps[-1]:g} ms. Never below d_m by more than {1000 * TOLERANCE:g} mm at any of these time steps: "
        + (", ".join(keep) if keep else "none")
        + ".",
        "A continuous velocity has the same largest q̈ at every dt, p = 0; a jump asks for twice the acceleration at half the time step, "
        "p = 1, which no real arm can follow. Here every law sees the distance that is smooth everywhere, so that neither a change of "
        "the closest pair nor two parallel links make it jump.",
        *_sorted_by_change(plain, steps),
        *jumps,
        "Each of the others has few settings of its own, left at their defaults: this is no contest; see `equal_safety` for one.",
    ]


def _sorted_by_change(runs: dict[str, list[Summary]], steps: Sequence[float]) -> list[str]:
    paper = next(iter(runs.values()))[-1].ddq_max
    jump = [label for label, summaries in runs.items() if growth(summaries, steps) > JUMPS]
    fast = [
        label
        for label, summaries in runs.items()
        if label not in jump and summaries[-1].ddq_max > FAST * paper
    ]
    said = {
        f"q̇ jumps (p above {JUMPS:g})": jump,
        f"q̇ changes fast, more than {FAST:g} times the paper's law's, but does not jump": fast,
    }
    return [f"{what}: {', '.join(labels) if labels else 'none'}." for what, labels in said.items()]
