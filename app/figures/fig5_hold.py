"""Fig. 5: one arm holds its hand in place, a person moves the other. Distance and squared error over time.

And section III along its run: the smallest eigenvalue of M's symmetric part, and what holds in its place.
"""

from typing import Final

import numpy as np

from app.figures.drawn_figure import COLOURS, DASHES, INK, Drawn, Plan, csv_head, stack, tag
from app.plots.time_plots import CEILING
from app.plots.time_series import resting
from controllers.kinematics import Array
from controllers.stability import Analysis, analyse
from controllers.tasks import TASK_DIMENSION
from scenes.headless import Run
from scenes.history import COLUMN

FELT = 0.05
"""From this λ on there is something to avoid."""

LONGEST = 0.5
"""Resting distances beyond this are as good as infinite here [m]."""


def seconds(plan: Plan) -> float:
    """Return the length of the run [s]; the paper's figure has 50 s."""
    return plan.either(50.0, 12.0)


def draw(plan: Plan) -> Drawn:
    single = plan.settings({"pairs": "single"})
    length = seconds(plan)
    paper = plan.shared(single, length)
    ours = plan.shared(plan.settings({"pairs": "soft"}), length)
    time, d, e2 = (paper.table[:, COLUMN[name]] for name in ("t", "d", "e2"))
    # For the pull and the approach of every step; nan where nothing is at rest so near.
    rest = np.array([resting(single, u, w, None) for u, w in paper.table[:, [COLUMN["u"], COLUMN["w_law"]]].tolist()])
    rest = np.where(rest < LONGEST, rest, np.nan)
    figure, (upper, lower) = stack(4.0, 2)
    critical = single.law.critical_distance
    upper.plot(time, rest, color=COLOURS.resting, linestyle=DASHES[2], linewidth=1.2, label="$d^*$")
    upper.plot(time, d, color=COLOURS.distance, label="$d$")
    upper.axhline(critical, color=COLOURS.critical, linestyle=DASHES[4], linewidth=1.3, label="$d_m$")
    tag(upper, "$d_m$", 0.004 * length, critical - 0.028, COLOURS.critical, 12)
    upper.set(ylim=(0, CEILING), yticks=np.arange(0, CEILING + 0.01, 0.1), ylabel="distance [m]")
    upper.legend(handles=upper.lines[1::-1], loc="upper right", ncols=2, bbox_to_anchor=(1.0, 1.13), borderaxespad=0.0)
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
    """Return whether the distance stayed above d_m, and how near it came."""
    critical = run.simulation.settings.law.critical_distance
    word = "never passes" if run.summary.d_min >= critical else "**passes**"
    return (
        f"The distance {word} d_m = {1000 * critical:.0f} mm: its minimum is {1000 * run.summary.d_min:.1f} mm, between "
        f"{run.summary.d_min_pair}."
    )


def switches(run: Run) -> int:
    """Return how often another pair became the closest where it mattered: far away the pairs of two shoulders may well take turns."""
    pair, lam = run.table[:, COLUMN["pair"]], run.table[:, COLUMN["lambda"]]
    return int(np.count_nonzero((np.diff(pair) != 0.0) & (lam[1:] > FELT)))


def approach(run: Run) -> float:
    """Return how fast the other arm came at most, where it mattered [m/s]."""
    near = run.table[:, COLUMN["lambda"]] > 0.5
    return float(run.table[near, COLUMN["w"]].max()) if near.any() else 0.0


BACK: Final = 0.01
"""Share of its peak at which the error counts as gone."""

PERIOD: Final = 0.05
"""Simulated time between two rows [s]."""


def along(run: Run) -> tuple[Array, list[Analysis]]:
    """Return the rows of a hold run that are looked at, and section III's quantities at each, with K_a = K_b = K."""
    simulation, settings = run.simulation, run.simulation.settings
    kinematics, arm, law = simulation.kinematics, simulation.avoiding, settings.law
    table = run.table[:: max(1, round(PERIOD / settings.dt))]
    found: list[Analysis] = []
    for positions, lam in zip(simulation.history.positions(table), table[:, COLUMN["lambda"]].tolist(), strict=True):
        kinematics.update(np.ascontiguousarray(positions))
        near = simulation.detector.detect(law.pairs, law.beta)
        J = kinematics.hand_jacobian(arm)[: TASK_DIMENSION[settings.task]]
        found.append(analyse(near.row[arm.joints], J, lam, settings.gain, settings.gain))
    return table, found


def draw_stability(plan: Plan) -> Drawn:
    """M's smallest eigenvalue, 1 − λρ² and the error over time."""
    settings, length = plan.settings({"pairs": "single"}), seconds(plan)
    table, found = along(plan.shared(settings, length))
    _, posed = along(plan.shared(plan.settings({"pairs": "single"}, task="pose"), length))
    time, lam, e2 = (table[:, COLUMN[name]] for name in ("t", "lambda", "e2"))
    least = np.array([a.smallest_eigenvalue for a in found]) / settings.gain
    survival = np.array([a.survival for a in found])
    figure, (upper, middle, lower) = stack(5.2, 3)
    upper.axhline(0.0, color=COLOURS.critical, linestyle=DASHES[4], linewidth=1.2)
    upper.plot(time, least, color=INK, linewidth=1.4)
    upper.fill_between(time, least, 0.0, where=least < 0.0, color=COLOURS.approach, alpha=0.16, linewidth=0)
    upper.set(ylabel="smallest\neigenvalue / $K$")
    middle.plot(time, survival, color=COLOURS.activation)
    middle.plot(time, 1.0 - lam, color=COLOURS.activation, linestyle=DASHES[2], linewidth=1.3)
    middle.set(ylabel=r"$1-\lambda\rho^2$", ylim=(-0.03, 1.05), yticks=(0, 0.5, 1))
    lower.plot(time, e2, color=COLOURS.error)
    lower.set(ylabel="$e^2$ [m²]", xlabel="time [s]", xlim=(0, length), ylim=(0, None))
    rows = np.column_stack(
        [
            *(time, lam, e2, least * settings.gain, survival),
            [a.rho for a in found],
            [a.coupling for a in found],
            [float(a.independent) for a in found],
        ]
    ).tolist()
    columns = ["t", "lambda", "e2", "eigenvalue", "survival", "rho", "coupling", "independent"]
    header = csv_head(settings, seconds=length, k_a=settings.gain)
    return Drawn(figure, columns, rows, header, [_sentence("position", found), _sentence("pose", posed), *_verdict(e2, found)])


def _sentence(task: str, found: list[Analysis]) -> str:
    busy = [a for a in found if a.activation > FELT and a.rank_a]
    if not busy:
        return f"Task “{task}”: nothing to avoid in this run."
    share = 100.0 * float(np.mean([a.smallest_eigenvalue > 0.0 for a in busy]))
    independent = 100.0 * float(np.mean([a.independent for a in busy]))
    orthogonal = 100.0 * float(np.mean([a.orthogonal for a in busy]))
    rho = float(np.median([a.rho for a in busy]))
    return (
        f"Task “{task}”, while λ > {FELT:g} (K_a = K): sym(M) > 0, the paper's condition, {share:.0f} % of the time; tasks "
        f"independent {independent:.0f} %, orthogonal {orthogonal:.0f} %; median ρ = {rho:.4f}."
    )


def _verdict(e2: Array, found: list[Analysis]) -> list[str]:
    peak = int(e2.argmax())
    after = float(e2[peak:].min())
    lowest = min(a.survival for a in found)
    back = (
        f"The condition is sufficient, not necessary: e² rises to {e2[peak]:.3f} m² and comes back to {after:.1e} m² once the other arm "
        "leaves, whatever the sign of the smallest eigenvalue."
        if after < BACK * e2[peak]
        else f"e² rises to {e2[peak]:.3f} m², and the run ends before the other arm leaves."
    )
    return [
        back,
        f"What decides is 1 − λρ², the part of the task that survives along the line of contact (dotted: 1 − λ, its value for ρ = 1); "
        f"its smallest value here is {lowest:.3f}.",
    ]
