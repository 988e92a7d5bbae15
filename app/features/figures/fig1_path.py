"""Fig. 1: a hand's path past an obstacle, and the critical point."""

from dataclasses import replace
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle
from matplotlib.patheffects import withStroke

from app.features.figures.drawn_figure import COLOURS, DASHES, INK, Drawn, Plan, csv_head, sheet
from app.features.figures.render import Viewpoint, arms, ball, furniture, render
from controllers.kinematics import Array
from scenes.ball import BALL_RADIUS, POINT_RADIUS, REST, TRAVEL, path
from scenes.experiments import BALL
from scenes.headless import Run
from scenes.history import COLUMN
from scenes.rigs import Camera

CAMERA: Final = Camera((-0.05, 0.17, 1.24), (2.6, -0.9, 0.55), 1.35, 1.02, float(np.radians(26.0)))
OUTLINE: Final = withStroke(linewidth=3.0, foreground="white", alpha=0.8)

BALL_COLOUR: Final = np.array([0.52, 0.04, 0.03])
"""Linear RGB."""

GHOST: Final = 0.34


def draw(plan: Plan) -> Drawn:
    settings = plan.settings({"pairs": "single"}, scene=BALL, point="hand", ball="still")
    length = REST + TRAVEL + REST
    run = plan.shared(settings, length)
    finer = plan.run(replace(settings, dt=settings.dt / 2.0), length)
    # The rest at A shows nothing.
    table = run.table[round(REST / settings.dt) :]
    hand, wanted, centre = _ways(run, table)
    d, nearest = table[:, COLUMN["d"]], int(table[:, COLUMN["d"]].argmin())
    figure = sheet(5.9)
    upper, lower = figure.subplots(2, 1, height_ratios=(1.85, 1.0))
    _photo(upper, run, table, nearest, plan.either((840, 600), (210, 150)), (hand, wanted, centre))
    clear = settings.law.critical_distance
    _side(lower, (hand, wanted, centre), nearest, clear)
    least = float(np.linalg.norm(wanted - centre, axis=1).min()) - BALL_RADIUS - POINT_RADIUS
    found = [
        f"The desired way would bring the control point to {1000 * least:.0f} mm from the ball; the actual one stays "
        f"{1000 * d.min():.1f} mm away, d_m = {1000 * clear:.0f} mm.",
        f"The hand leaves its path by up to {1000 * run.summary.e2_max**0.5:.0f} mm and rests "
        f"{1000 * float(table[-1, COLUMN['e2']]) ** 0.5:.1f} mm beside B, where λ is still {table[-1, COLUMN['lambda']]:.3f}.",
        f"The critical point is fixed, so that nothing can jump: the largest step of q̇ is {run.summary.dq_step_max:.4f} rad/s at "
        f"dt = {1000 * settings.dt:g} ms and {finer.summary.dq_step_max:.4f} rad/s at half of it.",
    ]
    columns = ["t", *(f"{name}_{axis}" for name in ("desired", "actual") for axis in "xyz"), "d", "lambda"]
    rows = np.column_stack([table[:, 0], wanted, hand, d, table[:, COLUMN["lambda"]]]).tolist()
    header = csv_head(
        settings,
        seconds=length,
        ball_x=centre[0],
        ball_y=centre[1],
        ball_z=centre[2],
        ball_radius=BALL_RADIUS,
    )
    return Drawn(figure, columns, rows, header | {"point_radius": POINT_RADIUS}, found)


def _ways(run: Run, table: Array) -> tuple[Array, Array, Array]:
    """Hand (k, 3), desired hand (k, 3), and centre of the ball (3,) [m]."""
    room, kinematics = run.simulation.room, run.simulation.kinematics
    kinematics.update(room.start)
    home = kinematics.hand_pose(room.arms[0]).translation.copy()
    hand = np.empty((len(table), 3))
    for row, positions in zip(hand, run.simulation.history.positions(table), strict=True):
        kinematics.update(np.ascontiguousarray(positions))
        row[:] = kinematics.hand_pose(room.arms[0]).translation
    assert room.ball is not None
    return hand, np.array([path(t, home)[0] for t in table[:, 0]]), room.start[room.ball].copy()


def _photo(
    axes: Axes, run: Run, table: Array, nearest: int, size: tuple[int, int], ways: tuple[Array, Array, Array]
) -> None:
    room, positions = run.simulation.room, run.simulation.history.positions(table)
    hand, wanted, centre = ways
    still = [*furniture(room), ball(centre, BALL_RADIUS, BALL_COLOUR)]
    empty = render(still, CAMERA, *size).astype(float)
    taken = [
        render([*still, *arms(room, positions[i], ("orange",))], CAMERA, *size).astype(float)
        for i in (0, -1, nearest)
    ]
    picture = empty + GHOST * (taken[0] - empty) + GHOST * (taken[1] - empty)
    there = np.abs(taken[2] - empty).max(2, keepdims=True) > 2.0
    picture = np.where(there, taken[2], np.clip(picture, 0.0, 255.0))
    axes.imshow(picture.astype(np.uint8), interpolation="lanczos")
    view = Viewpoint(CAMERA, *size)
    for way, colour, dash, width in (
        (wanted, COLOURS.critical, DASHES[1], 1.6),
        (hand, COLOURS.distance, DASHES[0], 2.2),
    ):
        x, y = view.project(way).T
        axes.plot(x, y, color="white", linewidth=width + 1.8, alpha=0.75, solid_capstyle="butt")
        axes.plot(x, y, color=colour, linestyle=dash, linewidth=width)
    for text, point in (("A", wanted[0]), ("B", wanted[-1])):
        ((x, y),) = view.project(point[None])
        axes.text(
            x,
            y - 0.035 * size[1],
            text,
            ha="center",
            va="bottom",
            fontsize=12,
            fontweight="bold",
            path_effects=[OUTLINE],
        )
    axes.set(xlim=(0, size[0]), ylim=(size[1], 0))
    axes.axis("off")


def _side(axes: Axes, ways: tuple[Array, Array, Array], nearest: int, clear: float) -> None:
    hand, wanted, centre = ways
    along = (wanted[-1] - wanted[0]) / np.linalg.norm(wanted[-1] - wanted[0])
    flat: list[Array] = []
    for way in (wanted, hand):
        ahead = (way - centre) @ along
        flat.append(np.stack([ahead, np.linalg.norm(way - centre - ahead[:, None] * along, axis=1)], 1))
    axes.add_patch(Circle((0.0, 0.0), BALL_RADIUS, facecolor=COLOURS.approach, alpha=0.85, linewidth=0))
    axes.text(0.0, 0.035, "ball", color="white", ha="center", va="center", fontsize=10)
    reach = BALL_RADIUS + POINT_RADIUS + clear
    axes.add_patch(
        Circle(
            (0.0, 0.0),
            reach,
            facecolor="none",
            edgecolor=COLOURS.critical,
            linestyle=DASHES[2],
            linewidth=1.4,
        )
    )
    axes.text(0.255, 0.035, "here $d=d_m$", color=COLOURS.critical, ha="right", fontsize=9.5)
    axes.plot(*flat[0].T, color=COLOURS.critical, linestyle=DASHES[1], label="desired")
    axes.plot(*flat[1].T, color=COLOURS.distance, label="actual")
    at = flat[1][nearest]
    axes.add_patch(Circle(tuple(at), POINT_RADIUS, facecolor=COLOURS.distance, alpha=0.18, linewidth=0))
    axes.plot(*at, "o", color=COLOURS.distance, markersize=5, markeredgecolor="white")
    axes.annotate(
        "critical point", at, (-8.0, 14.0), textcoords="offset points", ha="right", fontsize=9.5, color=INK
    )
    for text, point in (("A", flat[0][0]), ("B", flat[0][-1])):
        axes.plot(*point, "s", color=INK, markersize=4.5)
        axes.annotate(
            text, point, (0.0, -11.0), textcoords="offset points", ha="center", va="center", fontweight="bold"
        )
    axes.set(
        xlabel="way along A–B, from the ball [m]",
        ylabel="beside it [m]",
        aspect="equal",
        xlim=(-0.4, 0.4),
        ylim=(0, 0.38),
    )
    axes.legend(loc="upper right", bbox_to_anchor=(1.02, 1.04))
