"""Fig. 2, λ over d, and Fig. 4, the control scheme."""

from typing import Final, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, FancyArrowPatch, FancyBboxPatch

from app.features.figures.drawn_figure import COLOURS, DASHES, INK, PALE, Drawn, Plan, sheet, tag
from controllers.activation import activation

CRITICAL_DISTANCE = 0.1
"""d_m of Fig. 2 [m]."""

ORDERS = (1, 2, 10)


def draw_activation(plan: Plan) -> Drawn:
    distances = np.linspace(0.0, 1.0, plan.either(1001, 101))
    curves = [[activation(float(d), CRITICAL_DISTANCE, n) for d in distances] for n in ORDERS]
    figure = sheet(2.9)
    axes = figure.subplots()
    for n, curve, dash, at in zip(ORDERS, curves, DASHES, (0.62, 0.345, 0.128), strict=False):
        axes.plot(distances, curve, color=COLOURS.activation, linestyle=dash, label=f"$n={n}$")
        tag(
            axes, f"$n={n}$", at + 0.012, activation(at, CRITICAL_DISTANCE, n) + 0.035, COLOURS.activation, 11
        )
    axes.axvline(CRITICAL_DISTANCE, color=COLOURS.critical, linestyle=DASHES[4], linewidth=1.3)
    tag(axes, "$d_m$", CRITICAL_DISTANCE + 0.012, 1.05, COLOURS.critical, 12)
    axes.set(
        xlim=(0, 1),
        ylim=(0, 1.1),
        xlabel=r"distance $d$ [m]",
        ylabel=r"activation $\lambda$",
        yticks=np.arange(0, 1.1, 0.2),
    )
    at_twice = [activation(2 * CRITICAL_DISTANCE, CRITICAL_DISTANCE, n) for n in ORDERS]
    at_one = [activation(1.0, CRITICAL_DISTANCE, n) for n in ORDERS]
    found = [
        "At twice d_m λ is "
        + ", ".join(f"{x:.3g} (n = {n})" for x, n in zip(at_twice, ORDERS, strict=True))
        + ".",
        "λ never reaches 0: at 1 m, ten times d_m, it still is "
        + ", ".join(f"{x:.1g} (n = {n})" for x, n in zip(at_one, ORDERS, strict=True))
        + ", so that for small n an arm with nothing to avoid is pushed all the same (see `bias`).",
        "λ is continuous, its slope is not: at d_m it jumps from 0 to −n/d_m = "
        + ", ".join(f"{-n / CRITICAL_DISTANCE:.0f}" for n in ORDERS)
        + " 1/m.",
    ]
    rows = [[float(d), *(curve[i] for curve in curves)] for i, d in enumerate(distances)]
    return Drawn(figure, ["d", *(f"lambda_n{n}" for n in ORDERS)], rows, {"dm": CRITICAL_DISTANCE}, found)


class SchemeBlock(NamedTuple):
    """A box of the diagram."""

    x: float
    y: float
    width: float
    height: float
    name: str
    formula: str
    colour: str


BLOCKS: Final = {
    "task": SchemeBlock(1.1, 3.6, 1.9, 1.05, "task", r"$\dot q_n$  or  $J^{\#}\dot x_c$", COLOURS.pull),
    "projector": SchemeBlock(
        3.75, 3.6, 1.95, 1.05, "soft null space", r"$N' = I - \lambda J_d^{\#} J_d$", INK
    ),
    "row": SchemeBlock(3.75, 1.85, 1.95, 1.05, "avoidance", r"$J_d^{\#}\,\lambda v$", COLOURS.velocity),
    "integral": SchemeBlock(6.85, 3.6, 1.1, 1.05, "arm", r"$\int \dot q\,\mathrm{d}t$", INK),
    "kinematics": SchemeBlock(6.85, 1.85, 1.95, 1.05, "forward kinematics", r"$x = f(q)$", INK),
    "proximity": SchemeBlock(6.85, 0.45, 1.95, 0.85, "proximity detection", r"$d,\ n_0$", COLOURS.distance),
    "activation": SchemeBlock(
        1.1, 1.15, 1.9, 1.05, "activation", r"$\lambda(d)$, eq. (31)", COLOURS.activation
    ),
}

SUM: Final = (5.4, 3.6)
RADIUS: Final = 0.17

ARROWS: Final = (
    ("task", "projector", "q̇_n", "what the task asks for, eq. (7) or joint speeds directly"),
    ("projector", "sum", "N' q̇_n", "what is left of it, eq. (33)"),
    ("activation", "projector", "λ", "how far avoidance has taken over, eq. (31)"),
    ("activation", "row", "λ", "the same"),
    ("row", "sum", "J_d^# λ v", "the retreat, eqs (5), (30)"),
    ("sum", "integral", "q̇", "joint velocities, eq. (32)"),
    ("integral", "kinematics", "q", "joint positions"),
    ("kinematics", "proximity", "x", "where the bodies are, eq. (1)"),
    ("proximity", "activation", "d", "the closest distance"),
    ("proximity", "row", "J_d", "its gradient, eqs (26), (27)"),
    ("proximity", "projector", "J_d", "the same"),
    ("integral", "task", "q, x", "back to the task's controller, eq. (8)"),
)
"""From, to, signal, meaning."""


def draw_scheme(plan: Plan) -> Drawn:
    del plan
    figure = sheet(3.35, 6.0)
    figure.set_layout_engine("none")
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set(xlim=(0.02, 7.98), ylim=(-0.12, 4.62), aspect="equal")
    axes.axis("off")
    for block in BLOCKS.values():
        _box(axes, block)
    axes.add_patch(Circle(SUM, RADIUS, facecolor="white", edgecolor=INK, linewidth=1.2, zorder=3))
    axes.text(*SUM, "+", ha="center", va="center", fontsize=13, zorder=4)
    _wires(axes)
    found = [
        "The scheme is drawn, not photographed: every block is a function of this program, and the CSV lists its signals.",
        "J_d is one row, so that no n × n matrix is built: N' q̇_n + J_d^# λ v is the same as q̇_n + J_d^# λ (v + u) with "
        "u = −J_d q̇_n.",
        "What the paper's figure does not show is a bound on q̇: cutting off q̇ behind the sum would break the avoidance, so ours is "
        "part of the sum (see `controllers/limits.py`).",
    ]
    return Drawn(figure, ["from", "to", "signal", "meaning"], ARROWS, {}, found)


def _box(axes: Axes, block: SchemeBlock) -> None:
    corner = (block.x - block.width / 2.0, block.y - block.height / 2.0)
    style = "round,pad=0,rounding_size=0.09"
    axes.add_patch(
        FancyBboxPatch(
            corner,
            block.width,
            block.height,
            boxstyle=style,
            facecolor=PALE,
            edgecolor=block.colour,
            linewidth=1.4,
            zorder=2,
        )
    )
    axes.text(block.x, block.y + 0.22, block.name, ha="center", va="center", fontsize=8.6, zorder=4)
    axes.text(
        block.x,
        block.y - 0.2,
        block.formula,
        ha="center",
        va="center",
        fontsize=11,
        color=block.colour,
        zorder=4,
    )


def _wire(axes: Axes, *points: tuple[float, float], colour: str = INK) -> None:
    *_, start, end = points
    if len(points) > 2:
        xs, ys = zip(*points[:-1], strict=True)
        axes.plot(
            xs, ys, color=colour, linewidth=1.3, solid_joinstyle="round", solid_capstyle="butt", zorder=1
        )
    head = "-|>,head_length=5,head_width=2.4"
    axes.add_patch(
        FancyArrowPatch(
            start,
            end,
            arrowstyle=head,
            color=colour,
            linewidth=1.3,
            shrinkA=0,
            shrinkB=0,
            mutation_scale=1,
            zorder=1,
        )
    )


def _dot(axes: Axes, x: float, y: float, colour: str) -> None:
    axes.add_patch(Circle((x, y), 0.045, color=colour, zorder=3))


def _wires(axes: Axes) -> None:
    left, right = (
        {k: b.x - b.width / 2 for k, b in BLOCKS.items()},
        {k: b.x + b.width / 2 for k, b in BLOCKS.items()},
    )
    low, high = (
        {k: b.y - b.height / 2 for k, b in BLOCKS.items()},
        {k: b.y + b.height / 2 for k, b in BLOCKS.items()},
    )
    y, (sx, sy) = {k: b.y for k, b in BLOCKS.items()}, SUM
    _wire(axes, (right["task"], y["task"]), (left["projector"], y["task"]), colour=COLOURS.pull)
    _label(axes, 2.4, y["task"] + 0.2, r"$\dot q_n$", COLOURS.pull)
    _wire(axes, (right["projector"], sy), (sx - RADIUS, sy))
    _wire(axes, (right["row"], y["row"]), (sx, y["row"]), (sx, sy - RADIUS), colour=COLOURS.velocity)
    _wire(axes, (sx + RADIUS, sy), (left["integral"], sy))
    _label(axes, 5.93, sy + 0.22, r"$\dot q$")
    _wire(axes, (6.85, low["integral"]), (6.85, high["kinematics"]))
    _label(axes, 7.03, 2.73, r"$q$")
    _wire(axes, (6.85, low["kinematics"]), (6.85, high["proximity"]))
    _label(axes, 7.05, 1.1, r"$x$")
    # λ leaves to the right and goes up to N' and across to the row.
    lam, fork = COLOURS.activation, 2.36
    _wire(axes, (right["activation"], 1.55), (fork, 1.55), (left["row"], 1.55), colour=lam)
    _wire(axes, (fork, 1.55), (fork, 2.72), (3.35, 2.72), (3.35, low["projector"]), colour=lam)
    _dot(axes, fork, 1.55, lam)
    _label(axes, fork - 0.17, 2.2, r"$\lambda$", lam)
    # d and J_d return along the bottom.
    d = COLOURS.distance
    _wire(axes, (left["proximity"], 0.27), (1.1, 0.27), (1.1, low["activation"]), colour=d)
    _label(axes, 2.6, 0.45, r"$d$", d)
    _wire(axes, (left["proximity"], 0.62), (3.35, 0.62), (3.35, low["row"]), colour=d)
    _label(axes, 4.6, 0.83, r"$J_d$", d)
    _dot(axes, 4.15, 0.62, d)
    _wire(
        axes,
        (4.15, 0.62),
        (4.15, 1.0),
        (4.96, 1.0),
        (4.96, 2.72),
        (4.15, 2.72),
        (4.15, low["projector"]),
        colour=d,
    )
    # Back to the task.
    out = right["integral"] + 0.3
    _wire(axes, (right["integral"], sy), (out, sy), (out, 4.42), (1.1, 4.42), (1.1, high["task"]))
    _label(axes, 4.4, 4.27, r"$q,\ x$")


def _label(axes: Axes, x: float, y: float, text: str, colour: str = INK) -> None:
    axes.text(x, y, text, ha="center", va="center", fontsize=11, color=colour, zorder=4)
