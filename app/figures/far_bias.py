"""How far an arm with nothing to avoid is pushed away all the same, since λ never reaches 0."""

import numpy as np

from app.figures.drawn_figure import Drawn, Plan, csv_head
from app.figures.figure_style import COLOURS, DASHES, sheet
from controllers import budget
from scenes.headless import Run
from scenes.history import COLUMN
from scenes.roles import NoSource


def expected(run: Run) -> float:
    """Return |e| that the closed form gives for the posture at the end of a run [m].

    At rest ḋ = 0 with w = 0, so that u = λ v / (1 − λ), and q̇_n = J^# K e has to be parallel to J_d: K e = −u J J_dᵀ / (J_d J_dᵀ).
    """
    simulation, law = run.simulation, run.simulation.settings.law
    kinematics, arm = simulation.kinematics, simulation.avoiding
    kinematics.update(simulation.positions)
    near = simulation.detector.detect(law.pairs, law.beta)
    row = near.row[arm.joints]
    along = np.linalg.norm(kinematics.hand_jacobian(arm)[:3] @ row) / float(row @ row)
    lam = simulation.law.activation(near.law_distance)
    pull = budget.far_bias_speed(near.law_distance, law.critical_distance, law.order, law.nominal_velocity) / (1.0 - lam)
    return float(pull * along / simulation.settings.gain)


def draw(plan: Plan) -> Drawn:
    orders = plan.either((1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 14.0, 20.0), (2.0, 6.0))
    length = plan.either(60.0, 20.0)
    base = plan.settings({"pairs": "soft"}, rig="table")
    rows: list[list[float]] = []
    for n in orders:
        run = plan.run(plan.settings({"pairs": "soft", "order": n}, rig="table"), length, NoSource())
        d = float(run.table[-1, COLUMN["d"]])
        rows.append([n, d, float(run.table[-1, COLUMN["lambda"]]), run.summary.e2_end**0.5, expected(run)])
    table = np.array(rows)
    figure = sheet(2.9)
    axes = figure.subplots()
    axes.plot(table[:, 0], 1000 * table[:, 4], color=COLOURS.error, linestyle=DASHES[0], linewidth=1.5, label="closed form")
    axes.plot(
        table[:, 0], 1000 * table[:, 3], "o", color=COLOURS.error, markersize=6, markeredgecolor="white", label="whole loop"
    )
    axes.set(
        yscale="log",
        xlabel="order $n$",
        ylabel="displacement $|e|$ [mm]",
        xlim=(0, 20.5),
        xticks=(1, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20),
    )
    axes.legend(loc="upper right")
    worst = float(np.abs(table[:, 3] / table[:, 4] - 1.0).max())
    found = [
        f"No arm is guided, and the arms stand {1000 * table[-1, 1]:.0f} mm apart (d_m = {1000 * base.law.critical_distance:.0f} mm), yet "
        "the hand is not where it belongs: "
        + ", ".join(f"{1000 * e:.2g} mm (n = {n:g})" for n, e in table[:, (0, 3)])
        + f" after {length:g} s.",
        "At rest λ v = (1 − λ) u, so that |e| = λ v |J J_dᵀ| / ((1 − λ) K |J_d|²); the whole loop agrees with it within "
        f"{100 * worst:.2g} %.",
        "So the joints are never quite unconstrained, since λ is never 0; with a large n it is too small to see.",
    ]
    columns = ["n", "d", "lambda", "e", "e_closed_form"]
    return Drawn(figure, columns, rows, csv_head(base, "n", seconds=length), found)
