"""Fig. 2: how far avoidance has taken over, λ over d."""

import numpy as np

from app.figures.drawn_figure import COLOURS, DASHES, Drawn, Plan, sheet, tag
from controllers.activation import activation

CRITICAL_DISTANCE = 0.1
"""d_m as in the paper's figure [m]."""

ORDERS = (1, 2, 10)


def draw(plan: Plan) -> Drawn:
    distances = np.linspace(0.0, 1.0, plan.either(1001, 101))
    curves = [[activation(float(d), CRITICAL_DISTANCE, n) for d in distances] for n in ORDERS]
    figure = sheet(2.9)
    axes = figure.subplots()
    for n, curve, dash, at in zip(ORDERS, curves, DASHES, (0.62, 0.345, 0.128), strict=False):
        axes.plot(distances, curve, color=COLOURS.activation, linestyle=dash, label=f"$n={n}$")
        tag(axes, f"$n={n}$", at + 0.012, activation(at, CRITICAL_DISTANCE, n) + 0.035, COLOURS.activation, 11)
    axes.axvline(CRITICAL_DISTANCE, color=COLOURS.critical, linestyle=DASHES[4], linewidth=1.3)
    tag(axes, "$d_m$", CRITICAL_DISTANCE + 0.012, 1.05, COLOURS.critical, 12)
    axes.set(
        xlim=(0, 1), ylim=(0, 1.1), xlabel=r"distance $d$ [m]", ylabel=r"activation $\lambda$", yticks=np.arange(0, 1.1, 0.2)
    )
    at_twice = [activation(2 * CRITICAL_DISTANCE, CRITICAL_DISTANCE, n) for n in ORDERS]
    at_one = [activation(1.0, CRITICAL_DISTANCE, n) for n in ORDERS]
    found = [
        "At twice d_m λ is " + ", ".join(f"{x:.3g} (n = {n})" for x, n in zip(at_twice, ORDERS, strict=True)) + ".",
        "λ never reaches 0: at 1 m, ten times d_m, it still is "
        + ", ".join(f"{x:.1g} (n = {n})" for x, n in zip(at_one, ORDERS, strict=True))
        + ", so that for small n an arm with nothing to avoid is pushed all the same (see `bias`).",
        "λ is continuous, its slope is not: at d_m it jumps from 0 to −n/d_m = "
        + ", ".join(f"{-n / CRITICAL_DISTANCE:.0f}" for n in ORDERS)
        + " 1/m.",
    ]
    rows = [[float(d), *(curve[i] for curve in curves)] for i, d in enumerate(distances)]
    return Drawn(figure, ["d", *(f"lambda_n{n}" for n in ORDERS)], rows, {"dm": CRITICAL_DISTANCE}, found)
