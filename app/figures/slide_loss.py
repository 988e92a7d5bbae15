"""What the arm loses of d_m while it slides along the tie of two pairs, over v, for the three treatments of the pairs."""

from dataclasses import replace
from typing import Final, get_args

from app.figures.drawn_figure import Drawn, Plan, csv_head
from app.figures.figure_style import COLOURS, DASHES, MARKERS, sheet
from controllers.choices import Treatment
from scenes.settings import RunSettings, specs

SEED: Final = 396
"""Of the person who moves the guided arm onto the tie, from the start `between`."""

SECONDS: Final = 12.0
"""Length of a run [s]; nothing is lost afterwards."""

COLOURS_OF: Final = {"single": COLOURS.approach, "soft": COLOURS.resting, "smooth": COLOURS.distance}


def draw(plan: Plan) -> Drawn:
    """d_m − d_min over v."""
    speeds = plan.either((0.0, 0.02, 0.05, 0.08, 0.1, 0.12, 0.15, 0.2, 0.25, 0.3), (0.05, 0.3))
    base = replace(plan.settings(start="between", avoid="guided"), seed=SEED)
    names = specs(RunSettings)["pairs"].options()
    figure = sheet(3.1)
    axes = figure.subplots()
    rows: list[list[object]] = []
    lost: dict[str, list[float]] = {}
    for i, pairs in enumerate(get_args(Treatment)):
        summaries = [
            plan.run(replace(base, law=replace(base.law, pairs=pairs, nominal_velocity=v)), SECONDS).summary for v in speeds
        ]
        lost[pairs] = [1000.0 * (base.law.critical_distance - s.d_min) for s in summaries]
        axes.plot(
            speeds, lost[pairs], color=COLOURS_OF[pairs], linestyle=DASHES[i], marker=MARKERS[i], markersize=5,
            markeredgecolor="white", label=names[pairs],
        )  # fmt: skip
        rows += [
            [pairs, v, s.d_min, loss, s.out_of_authority_s] for v, s, loss in zip(speeds, summaries, lost[pairs], strict=True)
        ]
    axes.axhline(0.0, color=COLOURS.critical, linestyle=DASHES[4], linewidth=1.3)
    axes.set(xlabel="speed of retreat $v$ [m/s]", ylabel="lost of $d_m$: $d_m - d_{min}$ [mm]", xlim=(0, None))
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
    return Drawn(figure, ["pairs", "v", "d_min", "lost_mm", "out_of_authority_s"], rows, csv_head(base, seconds=SECONDS), found)
