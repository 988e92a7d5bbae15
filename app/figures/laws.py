"""All laws on the same input, at several time steps: how near, how far off, how smooth."""

from app.figures.drawn import Drawn, shown
from app.figures.plan import Plan
from app.figures.style import COLOURS, DASHES, MARKERS, SERIES, stack
from scenes.headless import Summary
from scenes.settings import RunSettings, specs

JUMPS = 1.6
"""A law whose q̈ grows by more than this when dt is halved jumps; it would double."""


def draw(plan: Plan) -> Drawn:
    """d_min, e² and the largest q̈ over dt, law by law."""
    steps = plan.either((0.02, 0.01, 0.005, 0.0025), (0.02, 0.01))
    length = plan.either(46.0, 12.0)
    base = plan.settings(rig="table")
    choice = specs(RunSettings)["law"]
    labels = dict(zip(choice.choices, choice.choice_labels, strict=True))
    runs: dict[str, list[Summary]] = {
        law: [plan.run(plan.settings({"law": law}, rig="table", dt=dt), length).summary for dt in steps] for law in labels
    }
    figure, panels = stack(6.6, 3)
    for i, (law, summaries) in enumerate(runs.items()):
        style = {
            "marker": MARKERS[i % len(MARKERS)],
            "color": SERIES[i % len(SERIES)],
            "linestyle": DASHES[i % len(DASHES)],
            "markersize": 5.5,
            "markeredgecolor": "white",
            "linewidth": 1.5,
            "label": labels[law],
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
        [law, dt, s.d_min, s.share_below, s.e2_max, s.dq_step_max, s.ddq_max, s.pair_switches]
        for law, summaries in runs.items()
        for dt, s in zip(steps, summaries, strict=True)
    ]
    columns = ["law", "dt", "d_min", "share_below", "e2_max", "dq_step_max", "ddq_max", "pair_switches"]
    settings = {key: value for key, value in shown(base, seconds=length).items() if key not in ("law", "dt")}
    return Drawn(figure, columns, rows, settings, _found(runs, labels, base.law.critical_distance))


def _panels(summaries: list[Summary]) -> tuple[list[float], list[float], list[float]]:
    """Return what the three panels show of one law."""
    nan = float("nan")
    # A law that never moves the arm has no place on a logarithmic axis.
    return [s.d_min for s in summaries], [s.e2_max for s in summaries], [s.ddq_max or nan for s in summaries]


def _found(runs: dict[str, list[Summary]], labels: dict[str, str], critical: float) -> list[str]:
    """Return a table of the laws at the smallest time step, and who keeps d_m and who jumps."""
    lines = [
        "| law | d_min [mm] | time below d_m | e²_max [m²] | max q̈ [rad/s²] | q̈ when dt is halved |",
        "|---|---|---|---|---|---|",
    ]
    for law, summaries in runs.items():
        last, before = summaries[-1], summaries[-2]
        ratio = last.ddq_max / before.ddq_max if before.ddq_max else 1.0
        word = f"×{ratio:.2f}, a jump" if ratio > JUMPS else f"×{ratio:.2f}"
        lines.append(
            f"| {labels[law]} | {1000 * last.d_min:.1f} | {100 * last.share_below:.0f} % | {last.e2_max:.3f} | {last.ddq_max:.3g} "
            f"| {word} |"
        )
    keep = [labels[law] for law, s in runs.items() if min(x.d_min for x in s) >= critical]
    return [
        "\n".join(lines),
        "Never below d_m at any of these time steps: " + (", ".join(keep) if keep else "none") + ".",
        "A law with a continuous velocity has the same largest q̈ at every dt; one that jumps needs twice the acceleration at half the "
        "time step, that is, there is none that a real arm could follow.",
    ]
