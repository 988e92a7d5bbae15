"""All laws on the same input, at several time steps: how near, how far off, how smooth."""

import math
from collections.abc import Sequence
from typing import Any, Final

from app.figures.drawn import Drawn, shown
from app.figures.plan import Plan
from app.figures.style import COLOURS, DASHES, MARKERS, SERIES, stack
from scenes.headless import Summary
from scenes.settings import RunSettings, specs

TOLERANCE: Final = 2e-4
"""What counts as still on the threshold [m]: a law that rests on d_m itself overshoots by some of dt."""

JUMPS: Final = 0.4
"""A law whose largest q̈ grows faster than dt to the power of minus this jumps; a jump of q̇ makes it 1, a continuous q̇ 0."""


def variants() -> dict[str, dict[str, Any]]:
    """Return what a person reads → what is changed of the law's settings, for every law there is."""
    choice = specs(RunSettings)["law"]
    found: dict[str, dict[str, Any]] = {}
    for law, label in zip(choice.choices, choice.choice_labels, strict=True):
        found[label.replace("d_m", "$d_m$")] = {"law": law}
        if law == "barrier_qp":
            # A barrier means to be told how fast the obstacle comes.
            found["Barrier QP, told $w$"] = {"law": law, "feed_forward": True}
    return found


def draw(plan: Plan) -> Drawn:
    """d_min, e² and the largest q̈ over dt, law by law."""
    steps = plan.either((0.02, 0.01, 0.005, 0.0025), (0.02, 0.01))
    length = plan.either(46.0, 12.0)
    base = plan.settings(rig="table")
    runs: dict[str, list[Summary]] = {
        label: [plan.run(plan.settings(law, rig="table", dt=dt), length).summary for dt in steps]
        for label, law in variants().items()
    }
    figure, panels = stack(6.8, 3)
    for i, (label, summaries) in enumerate(runs.items()):
        style = {
            "marker": MARKERS[i % len(MARKERS)],
            "color": SERIES[i % len(SERIES)],
            "linestyle": DASHES[i % len(DASHES)],
            "markersize": 6.0,
            "markeredgecolor": "white",
            "markeredgewidth": 0.6,
            "linewidth": 1.5,
            "label": label,
        }
        for axes, values in zip(panels, _panels(summaries), strict=True):
            axes.plot([1000.0 * dt for dt in steps], values, **style)
    nearest, error, acceleration = panels
    nearest.axhline(base.law.critical_distance, color=COLOURS.critical, linestyle=DASHES[4], linewidth=1.2)
    nearest.set(ylabel=r"smallest $d$ [m]", xscale="log")
    error.set(ylabel=r"largest $e^2$ [m²]", ylim=(0, None))
    acceleration.set(ylabel=r"largest $\ddot q$ [rad/s²]", yscale="log", xlabel="time step [ms]")
    acceleration.set_xticks([1000.0 * dt for dt in steps], [f"{1000.0 * dt:g}" for dt in steps], minor=False)
    acceleration.set_xticks([], minor=True)
    figure.legend(*nearest.get_legend_handles_labels(), loc="outside lower center", ncols=2, fontsize=9.0)
    rows = [
        [law["law"], int("feed_forward" in law), dt, s.d_min, s.share_below, s.e2_max, s.dq_step_max, s.ddq_max, s.pair_switches]
        for law, summaries in zip(variants().values(), runs.values(), strict=True)
        for dt, s in zip(steps, summaries, strict=True)
    ]
    columns = ["law", "w_added", "dt", "d_min", "share_below", "e2_max", "dq_step_max", "ddq_max", "pair_switches"]
    settings = {key: value for key, value in shown(base, seconds=length).items() if key not in ("law", "ff", "dt")}
    return Drawn(figure, columns, rows, settings, _found(runs, steps, base.law.critical_distance))


def _panels(summaries: list[Summary]) -> tuple[list[float], list[float], list[float]]:
    """Return what the three panels show of one law."""
    nan = float("nan")
    # A law that never moves the arm has no place on a logarithmic axis.
    return [s.d_min for s in summaries], [s.e2_max for s in summaries], [s.ddq_max or nan for s in summaries]


def growth(runs: Sequence[Summary], steps: Sequence[float]) -> float:
    """Return p of q̈ ∝ dt^−p between the largest and the smallest time step; 0 for a law that never moves the arm."""
    if not runs[0].ddq_max:
        return 0.0
    return math.log(runs[-1].ddq_max / runs[0].ddq_max) / math.log(steps[0] / steps[-1])


def _found(runs: dict[str, list[Summary]], steps: Sequence[float], critical: float) -> list[str]:
    """Return a table of the laws at the smallest time step, and who keeps d_m and who jumps."""
    lines = [
        "| law | d_min [mm] | time below d_m | e²_max [m²] | max q̈ [rad/s²] | p in q̈ ∝ dt^−p |",
        "|---|---|---|---|---|---|",
    ]
    plain = {label.replace("$", ""): summaries for label, summaries in runs.items()}
    for label, summaries in plain.items():
        last, p = summaries[-1], round(growth(summaries, steps), 2) + 0.0
        word = f"{p:.2f}, jumps" if p > JUMPS else f"{p:.2f}"
        lines.append(
            f"| {label} | {1000 * last.d_min:.1f} | {100 * last.share_below:.0f} % | {last.e2_max:.3f} | {last.ddq_max:.3g} | {word} |"
        )
    keep = [label for label, s in plain.items() if min(x.d_min for x in s) >= critical - TOLERANCE]
    return [
        "\n".join(lines),
        f"In the table dt = {1000 * steps[-1]:g} ms. Never below d_m by more than {1000 * TOLERANCE:g} mm at any of these time steps: "
        + (", ".join(keep) if keep else "none")
        + ".",
        "A law with a continuous velocity has the same largest q̈ at every dt, p = 0; one that jumps asks for twice the acceleration at "
        "half the time step, p = 1, which no real arm can follow. Here every law sees the smooth minimum over all pairs, so that what "
        "jumps is the law.",
        "Each of the others has few settings of its own, left at their defaults: this is one experiment, not a contest.",
    ]
