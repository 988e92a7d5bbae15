"""Two equally close pairs: smoothness, and loss along their tie."""

from dataclasses import replace
from typing import Any, Final, get_args

import numpy as np

from app.features.figures.drawn_figure import COLOURS, DASHES, MARKERS, Drawn, Plan, csv_head, sheet, stack
from controllers.choices import Treatment
from scenes.headless import Summary
from scenes.settings import RunSettings, specs

LOOKS: Final[dict[Treatment, dict[str, Any]]] = {
    "single": {
        "marker": "o",
        "color": COLOURS.approach,
        "linestyle": DASHES[0],
        "label": "closest pair (paper)",
    },
    "soft": {
        "marker": "s",
        "color": COLOURS.velocity,
        "linestyle": DASHES[1],
        "label": "smooth minimum (ours)",
    },
}

MARKED: Final = {"markersize": 5.5, "markeredgecolor": "white"}


def draw(plan: Plan) -> Drawn:
    steps = plan.either((0.02, 0.01, 0.005, 0.0025, 0.00125), (0.02, 0.005))
    length = plan.either(46.0, 12.0)
    base = plan.settings(rig="table")
    runs: dict[Treatment, list[Summary]] = {
        pairs: plan.summaries([plan.settings({"pairs": pairs}, rig="table", dt=dt) for dt in steps], length)
        for pairs in LOOKS
    }
    milli = [1000.0 * dt for dt in steps]
    figure, (upper, lower) = stack(4.3, 2)
    for pairs, look in LOOKS.items():
        upper.plot(milli, [max(s.pair_switches, 0.5) for s in runs[pairs]], **look, **MARKED)
        lower.plot(milli, [s.dq_step_max for s in runs[pairs]], **look, **MARKED)
    reference = runs["soft"][0].dq_step_max * np.array(steps) / steps[0] * 0.55
    lower.plot(milli, reference, color=COLOURS.calm, linestyle=DASHES[2], linewidth=1.3)
    at = len(steps) // 2
    lower.text(
        milli[at] * 1.05,
        reference[at] * 0.72,
        r"$\propto \mathrm{d}t$",
        color=COLOURS.calm,
        va="top",
        fontsize=12,
    )
    upper.set(xscale="log", yscale="log", ylim=(1, 2e4), ylabel="changes of the\nclosest pair")
    lower.set(
        xscale="log",
        yscale="log",
        ylabel="largest step\n" r"of $\dot q$ [rad/s]",
        xlabel="time step [ms]",
        ylim=(5e-4, 3),
    )
    lower.set_xticks(milli, [f"{each:g}" for each in milli], minor=False)
    lower.set_xticks([], minor=True)
    figure.legend(*upper.get_legend_handles_labels(), loc="outside upper center", ncols=2)
    found = [_sentence(pairs, steps, runs[pairs]) for pairs in LOOKS]
    ratio = runs["single"][-1].dq_step_max / runs["single"][0].dq_step_max
    found.append(
        "A step of q̇ that halves with dt belongs to a continuous velocity; one that stays is a jump."
    )
    if ratio > 0.5 * (1.0 + steps[-1] / steps[0]):
        found.append(
            "The paper's law is continuous in d, but **not across a change of the closest pair**: a smaller time step does not make it "
            "smooth, it only makes it switch more often. This is a limit of the law as published, not of a program."
        )
    rows = [
        [pairs, dt, s.pair_switches, s.dq_step_max, s.ddq_max, s.d_min]
        for pairs, summaries in runs.items()
        for dt, s in zip(steps, summaries, strict=True)
    ]
    columns = ["pairs", "dt", "pair_switches", "dq_step_max", "ddq_max", "d_min"]
    return Drawn(figure, columns, rows, csv_head(base, "dt", "pairs", seconds=length), found)


def _sentence(pairs: Treatment, steps: tuple[float, ...], runs: list[Summary]) -> str:
    listed = ", ".join(str(s.pair_switches) for s in runs)
    times = ", ".join(f"{1000 * dt:g}" for dt in steps)
    jumps = ", ".join(f"{s.dq_step_max:.3g}" for s in runs)
    return f"{LOOKS[pairs]['label'].capitalize()}: {listed} changes of the closest pair at {times} ms; largest step of q̇ {jumps} rad/s."


SLIDE_SEED: Final = 396
"""Seed that moves the guided arm onto the tie, from the start `between`."""

SLIDE_SECONDS: Final = 12.0
"""[s]; nothing is lost later."""

COLOURS_OF: Final = {"single": COLOURS.approach, "soft": COLOURS.resting, "smooth": COLOURS.distance}


def draw_slide_loss(plan: Plan) -> Drawn:
    speeds = plan.either((0.0, 0.02, 0.05, 0.08, 0.1, 0.12, 0.15, 0.2, 0.25, 0.3), (0.05, 0.3))
    base = replace(plan.settings(start="between", avoid="guided"), seed=SLIDE_SEED)
    names = specs(RunSettings)["pairs"].options()
    figure = sheet(3.1)
    axes = figure.subplots()
    rows: list[list[object]] = []
    lost: dict[str, list[float]] = {}
    for i, pairs in enumerate(get_args(Treatment)):
        settings = [replace(base, law=replace(base.law, pairs=pairs, nominal_velocity=v)) for v in speeds]
        summaries = plan.summaries(settings, SLIDE_SECONDS)
        lost[pairs] = [1000.0 * (base.law.critical_distance - s.d_min) for s in summaries]
        axes.plot(
            speeds, lost[pairs], color=COLOURS_OF[pairs], linestyle=DASHES[i], marker=MARKERS[i], markersize=5,
            markeredgecolor="white", label=names[pairs],
        )  # fmt: skip
        rows += [
            [pairs, v, s.d_min, loss, s.out_of_authority_s]
            for v, s, loss in zip(speeds, summaries, lost[pairs], strict=True)
        ]
    axes.axhline(0.0, color=COLOURS.critical, linestyle=DASHES[4], linewidth=1.3)
    axes.set(
        xlabel="speed of retreat $v$ [m/s]", ylabel="lost of $d_m$: $d_m - d_{min}$ [mm]", xlim=(0, None)
    )
    axes.text(max(speeds), 3.0, "$d_m$", color=COLOURS.critical, ha="right", va="bottom", fontsize=12)
    axes.legend(loc="upper right")
    single = ", ".join(f"{loss:.0f} mm at {v:g} m/s" for v, loss in zip(speeds, lost["single"], strict=True))
    found = [
        "The guided arm keeps clear of an arm at rest (w = 0), and slides along a line where two pairs are equally near. "
        "d ≥ d_m if w ≤ v holds for one differentiable distance; the closest of two has a kink.",
        f"The closest pair, as in the paper, loses {single} (negative: kept).",
        *(
            f"{names[pairs]}: at worst {max(lost[pairs]):.1f} mm"
            + (", d_m is kept at every v." if max(lost[pairs]) <= 0.0 else ".")
            for pairs in lost
            if pairs != "single"
        ),
        f"Time out of authority, all runs together: {sum(float(row[4]) for row in rows):.2f} s.",  # pyright: ignore[reportArgumentType]
    ]
    columns = ["pairs", "v", "d_min", "lost_mm", "out_of_authority_s"]
    return Drawn(figure, columns, rows, csv_head(base, seconds=SLIDE_SECONDS), found)
