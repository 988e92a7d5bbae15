"""Section III along the run of Fig. 5: smallest eigenvalue of sym M, and a condition that holds."""

from typing import Final

import numpy as np

from app.features.figures import fig5_hold as hold
from app.features.figures.drawn_figure import COLOURS, DASHES, INK, Drawn, Plan, csv_head, stack
from controllers.kinematics import Array
from controllers.stability import Analysis, analyse
from controllers.tasks import TASK_DIMENSION
from scenes.headless import Run
from scenes.history import COLUMN

BACK: Final = 0.01
"""Share of its peak at which the error counts as gone."""

PERIOD: Final = 0.05
"""Simulated time between two rows [s]."""


def along(run: Run) -> tuple[Array, list[Analysis]]:
    """Rows of a hold run, and section III's quantities at each, with K_a = K_b = K."""
    simulation, settings = run.simulation, run.simulation.settings
    kinematics, arm, law = simulation.kinematics, simulation.avoiding, settings.law
    table = run.table[:: max(1, round(PERIOD / settings.dt))]
    found: list[Analysis] = []
    for positions, lam in zip(
        simulation.history.positions(table), table[:, COLUMN["lambda"]].tolist(), strict=True
    ):
        kinematics.update(np.ascontiguousarray(positions))
        near = simulation.detector.detect(*law.proximity)
        J = kinematics.hand_jacobian(arm)[: TASK_DIMENSION[settings.task]]
        found.append(analyse(near.row[arm.joints], J, lam, settings.gain, settings.gain))
    return table, found


def draw(plan: Plan) -> Drawn:
    settings, length = plan.settings({"pairs": "single"}), hold.seconds(plan)
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
    return Drawn(
        figure,
        columns,
        rows,
        header,
        [_sentence("position", found), _sentence("pose", posed), *_verdict(e2, found)],
    )


def _sentence(task: str, found: list[Analysis]) -> str:
    busy = [a for a in found if a.activation > hold.FELT and a.rank_a]
    if not busy:
        return f"Task “{task}”: nothing to avoid in this run."
    share = 100.0 * float(np.mean([a.smallest_eigenvalue > 0.0 for a in busy]))
    independent = 100.0 * float(np.mean([a.independent for a in busy]))
    orthogonal = 100.0 * float(np.mean([a.orthogonal for a in busy]))
    rho = float(np.median([a.rho for a in busy]))
    return (
        f"Task “{task}”, while λ > {hold.FELT:g} (K_a = K): sym(M) > 0, the paper's condition, {share:.0f} % of the time; tasks "
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
