"""Fig. 8, frames of the imitation, and Fig. 3, the two arms."""

from functools import cache
from typing import Final

import numpy as np
import pinocchio as pin
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke

from app.features.figures import fig5_hold as hold
from app.features.figures.drawn_figure import COLOURS, INK, Drawn, Plan, csv_head, sheet
from app.features.figures.fig6_fig7_followers import imitation_run
from app.features.figures.render import Mesh, Viewpoint, arms, furniture, meshes, render
from app.stage.camera_view import contact_points
from app.theme import blend
from controllers.kinematics import Array
from scenes.headless import Run
from scenes.history import COLUMN
from scenes.person.body import MATERIAL, BodyPart, body_parts, body_poses
from scenes.person.source import MissingPackage
from scenes.rigs import Camera
from scenes.targets import AnglesTarget

FRAMES: Final = 8
STRIDE: Final = 10

FILM_CAMERA: Final = Camera((0.20, 0.36, 1.11), (2.6, -0.3, 0.5), 2.25, 1.44, float(np.radians(26.0)))

STILL_CAMERA: Final = Camera((0.28, 0.0, 0.90), (2.45, -0.45, 0.69), 1.5, 0.92, float(np.radians(30.0)))

PERSON_PLACE: Final = np.array([-1.0, 1.25, 1.38])
"""Middle of the shoulders [m]."""

OUTLINE: Final = withStroke(linewidth=2.6, foreground="white", alpha=0.85)


def film(plan: Plan) -> Drawn:
    run, length = imitation_run(plan)
    table = run.table[moments_of(run)]
    size = plan.either((640, 400), (128, 80))
    figure = sheet(3.3, 10.4)
    figure.set_layout_engine("constrained", w_pad=0.02, h_pad=0.02, wspace=0.01, hspace=0.02)
    # The person of the run, evaluated again.
    person = run.simulation.source()
    for axes, row in zip(figure.subplots(2, FRAMES // 2).flat, table, strict=True):
        wanted = person.target(float(row[COLUMN["t"]]))
        angles = wanted.angles if isinstance(wanted, AnglesTarget) else None
        _frame(axes, run, row, FILM_CAMERA, size, posed_person(angles) if angles is not None else [])
        axes.text(
            0.025,
            0.955,
            f"{row[0]:.1f} s",
            transform=axes.transAxes,
            va="top",
            fontsize=13,
            path_effects=[OUTLINE],
        )
    d, places = table[:, COLUMN["d"]], marker_places(run, table)
    least = (np.linalg.norm(places[:, None] - places, axis=2) + np.diag([np.inf] * FRAMES)).min()
    found = [
        f"The {FRAMES} moments of the run of Fig. 7 that look most different: elbows, wrists and hands of any two are at least "
        f"{1000 * least:.0f} mm apart (root of the sum of squares), d between {1000 * d.min():.0f} and {1000 * d.max():.0f} mm. The line "
        "joins the closest points; the thicker and the more violet, the larger λ.",
        "Orange is the right arm, silver the left one; the person's own arms are those of the input at the same moment.",
    ]
    return _drawn(figure, run, table, length, found)


def _drawn(figure: Figure, run: Run, table: Array, length: float, found: list[str]) -> Drawn:
    simulation = run.simulation
    columns = ["t", "d", "lambda", *(name.format("q") for name in simulation.room.columns)]
    rows = np.column_stack(
        [table[:, [COLUMN[name] for name in columns[:3]]], simulation.history.positions(table)]
    ).tolist()
    return Drawn(figure, columns, rows, csv_head(simulation.settings, seconds=length), found)


def moments_of(run: Run) -> list[int]:
    """Rows (8,) with the most different postures, in order of time: the one farthest from the mean, then
    repeatedly the one farthest from all chosen.
    """
    places = marker_places(run, run.table[::STRIDE])
    picked = [int(np.linalg.norm(places - places.mean(0), axis=1).argmax())]
    nearest = np.full(len(places), np.inf)
    while len(picked) < FRAMES:
        nearest = np.minimum(nearest, np.linalg.norm(places - places[picked[-1]], axis=1))
        picked.append(int(nearest.argmax()))
    return [STRIDE * i for i in sorted(picked)]


def marker_places(run: Run, table: Array) -> Array:
    """Elbow, wrist and hand of both arms (rows, 18) [m]."""
    kinematics, room, found = run.simulation.kinematics, run.simulation.room, list[Array]()
    for positions in run.simulation.history.positions(table):
        kinematics.update(np.ascontiguousarray(positions))
        hands = [kinematics.hand_pose(arm).translation for arm in room.arms]
        joints = [kinematics.data.oMi[arm.joints.start + i].translation for arm in room.arms for i in (4, 6)]
        found.append(np.concatenate([*joints, *hands]))
    return np.array(found)


def still(plan: Plan) -> Drawn:
    length = hold.seconds(plan)
    run = plan.shared(plan.settings({"pairs": "single"}), length)
    # Just before the arms are nearest: both are visible, and so is λ.
    row = run.table[int(run.table[:, COLUMN["d"]].argmin())]
    figure = sheet(3.32)
    figure.set_layout_engine("none")
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    _frame(axes, run, row, STILL_CAMERA, plan.either((1040, 664), (130, 83)), [])
    found = [
        "The paper's photo shows two real arms; this is the model that all runs use, each arm at its place on the torso "
        f"(bases {2000 * abs(run.simulation.room.rig.bases[0].translation[1]):.0f} mm apart), at the moment of Fig. 5 when they are "
        f"nearest: {1000 * row[COLUMN['d']]:.1f} mm.",
        "All that is seen lies inside the capsules that are checked for collisions.",
    ]
    return _drawn(figure, run, row[None], length, found)


@cache
def person_parts() -> tuple[tuple[BodyPart, tuple[Mesh, ...]], ...]:
    """Empty without the package that draws a person."""
    try:
        return tuple((part, meshes(part.glb, {part.name: MATERIAL})) for part in body_parts())
    except MissingPackage:
        return ()


def posed_person(angles: Array) -> list[Mesh]:
    """The person with arms at angles (2, 4) [rad]."""
    poses, turns = {"": pin.SE3.Identity()}, body_poses(angles)
    drawn: list[Mesh] = []
    for part, looks in person_parts():
        local = pin.SE3(part.pose.rotation, PERSON_PLACE) if not part.parent else part.pose
        if part.name in turns:
            w, x, y, z = turns[part.name]
            local = pin.SE3(pin.Quaternion(w, x, y, z).toRotationMatrix(), local.translation)
        poses[part.name] = pose = poses[part.parent] * local
        drawn += [mesh.moved(pose.rotation, pose.translation) for mesh in looks]
    return drawn


def _frame(axes: Axes, run: Run, row: Array, camera: Camera, size: tuple[int, int], more: list[Mesh]) -> None:
    simulation = run.simulation
    positions = simulation.history.positions(row[None])[0].copy()
    drawn = [*furniture(simulation.room), *arms(simulation.room, positions, ("silver", "orange")), *more]
    axes.imshow(render(drawn, camera, *size), interpolation="lanczos")
    simulation.kinematics.update(positions)
    ends = Viewpoint(camera, *size).project(contact_points(simulation))
    lam = float(row[COLUMN["lambda"]])
    colour = tuple(c / 255.0 for c in blend(COLOURS.calm, COLOURS.activation, lam))
    width = 1.0 + 2.4 * lam
    axes.plot(*ends.T, color="white", linewidth=width + 1.6, alpha=0.8)
    axes.plot(
        *ends.T,
        color=colour,
        linewidth=width,
        marker="o",
        markersize=3.2,
        markerfacecolor=INK,
        markeredgewidth=0,
    )
    x, y = ends.mean(0)
    if lam > hold.FELT:
        axes.text(
            x,
            y - 0.045 * size[1],
            f"{1000.0 * row[COLUMN['d']]:.0f} mm",
            ha="center",
            va="bottom",
            fontsize=11,
            path_effects=[OUTLINE],
        )
    axes.set(xlim=(0, size[0]), ylim=(size[1], 0))
    axes.axis("off")
