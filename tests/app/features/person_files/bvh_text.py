"""Writes BVH files from a person's angles in the styles of different programs."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from controllers.kinematics import Array
from scenes.person.angles import SIGN, arm_rotation
from scenes.person.source import PersonSource
from tests.scenes.person.strategies import SIDES

Axes = tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]]

Y_UP: Axes = ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
"""Rotation from the torso frame to a file with y up and z forward."""

Z_UP: Axes = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True)
class Style:
    """A program's style: names of joints ("{}" is the side) and sides, order of rotations, rest pose [deg].

    Without a collar the upper arm is a child of the spine; without a wrist the forearm ends in an End Site.
    `axes` lead from the torso frame to the file's, where `unit` is one metre. `all_positions` are zeros.
    `roll` is the name's ending of twist joints in the middle of a bone.
    """

    hips: str = "Hips"
    spine: str = "Spine"
    collar: str = "{}Shoulder"
    shoulder: str = "{}Arm"
    elbow: str = "{}ForeArm"
    wrist: str = "{}Hand"
    thigh: str = "{}UpLeg"
    sides: tuple[str, str] = ("Left", "Right")
    order: str = "ZXY"
    axes: Axes = Y_UP
    unit: float = 100.0
    rest: tuple[float, float, float, float] = (0.0, 90.0, 0.0, 0.0)
    all_positions: bool = False
    roll: str = ""


MIXAMO = Style(
    "mixamorig:Hips", "mixamorig:Spine", "mixamorig:{}Shoulder", "mixamorig:{}Arm", "mixamorig:{}ForeArm", "mixamorig:{}Hand",
    "mixamorig:{}UpLeg",
)  # fmt: skip
TWISTED = replace(MIXAMO, roll="Roll")
POSER = Style(
    "hip", "abdomen", "{}Collar", "{}Shldr", "{}ForeArm", "{}Hand", "{}Thigh", ("l", "r"), "XZY", unit=40.0,
    rest=(0.0, 0.0, 0.0, 0.0),
)  # fmt: skip
BLENDER = Style(
    "pelvis", "spine", "clavicle.{}", "upper_arm.{}", "forearm.{}", "hand.{}", "thigh.{}", ("L", "R"), "XYZ", Z_UP, 1.0,
    (10.0, 45.0, 0.0, 20.0),
)  # fmt: skip
SNAKE = Style(
    "root",
    "spine",
    "",
    "{}_shoulder",
    "{}_elbow",
    "",
    "",
    ("left", "right"),
    "YXZ",
    Z_UP,
    39.37,
    (0.0, 90.0, 0.0, 0.0),
    True,
)
UNDERSCORE = Style(
    "Pelvis", "Spine", "{}_Collar", "{}_UpperArm", "{}_LowerArm", "{}_Hand", "{}_Thigh", ("L", "R"), "ZYX"
)

STYLES = {
    "mixamo": MIXAMO,
    "twisted": TWISTED,
    "poser": POSER,
    "blender": BLENDER,
    "snake": SNAKE,
    "underscore": UNDERSCORE,
}


Node = tuple[str, Array, Sequence["Node"]]
"""A joint, or an End Site if the name is empty: offset from the parent (3,) [m], and children."""


def _skeleton(style: Style, rests: list[Array]) -> Node:
    def bone(start: str, end: str, way: Array, hung: Node) -> Node:
        return (
            (start + style.roll, way / 2.0, [(end, way / 2.0, [hung])]) if style.roll else (end, way, [hung])
        )

    thighs: list[Node] = []
    arms: list[Node] = []
    (_, y, z), e = np.eye(3), np.radians(style.rest[3])
    for side, word, rest in zip(SIDES, style.sides, rests, strict=True):
        names = (style.collar, style.shoulder, style.elbow, style.wrist, style.thigh)
        collar, shoulder, elbow, wrist, thigh = (name.format(word) for name in names)
        aside, down, out = SIGN[side] * y, rest @ -z, rest @ [np.sin(e), 0.0, -np.cos(e)]
        hand: Node = bone(elbow, wrist, 0.26 * out, ("", 0.1 * out, [])) if wrist else ("", 0.26 * out, [])
        arm = [bone(shoulder, elbow, 0.31 * down, hand)]
        if collar:
            arms.append((collar, 0.05 * aside + 0.3 * z, [(shoulder, 0.15 * aside, arm)]))
        else:
            arms.append((shoulder, 0.2 * aside + 0.3 * z, arm))
        if thigh:
            thighs.append((thigh, 0.1 * aside, [("", -0.8 * z, [])]))
    return style.hips, 0.0 * z, [*thighs, (style.spine, 0.2 * z, arms)]


def write_bvh(
    source: PersonSource, style: Style, frames: int = 60, frame_time: float = 0.05, seed: int = 1
) -> str:
    """A BVH file of a person who also walks and turns."""
    C, drift = np.array(style.axes), np.random.default_rng(seed).uniform(-0.3, 0.3, 3)
    rests = [arm_rotation(np.radians(style.rest), side) for side in SIDES]
    rotations = " ".join(f"{axis}rotation" for axis in style.order)
    lines, joints = ["HIERARCHY"], list[tuple[str, bool]]()

    def write(node: Node, kind: str = "JOINT") -> None:
        name, offset, inside = node
        x, y, z = C @ offset * style.unit
        lines.extend((f"{kind} {name}" if name else "End Site", "{", f"OFFSET {x:.6f} {y:.6f} {z:.6f}"))
        if name:
            joints.append((name, kind == "ROOT" or style.all_positions))
            lines.append(
                f"CHANNELS 6 Xposition Yposition Zposition {rotations}"
                if joints[-1][1]
                else f"CHANNELS 3 {rotations}"
            )
        for child in inside:
            write(child)
        lines.append("}")

    write(_skeleton(style, rests), "ROOT")
    lines += ["MOTION", f"Frames: {frames}", f"Frame Time: {frame_time}"]
    for t in np.arange(frames) * frame_time:
        angles = source.angles(float(t))
        assert angles is not None
        turns = {style.hips: Rotation.from_euler("zyx", drift * t).as_matrix()}
        for arm, side, rest, word in zip(angles, SIDES, rests, style.sides, strict=True):
            # The forearm's rest direction is bent about the y axis of the resting upper arm.
            bend = Rotation.from_euler("y", np.radians(style.rest[3]) - arm[3]).as_matrix()
            turns[style.shoulder.format(word)] = upper = arm_rotation(arm, side) @ rest.T
            turns[style.elbow.format(word)] = upper.T @ arm_rotation(arm, side) @ bend @ rest.T
        row: list[float] = []
        for name, full in joints:
            if full:
                row += (C @ drift * t * style.unit if name == style.hips else np.zeros(3)).tolist()
            row += (
                Rotation.from_matrix(C @ turns.get(name, np.eye(3)) @ C.T)
                .as_euler(style.order, degrees=True)
                .tolist()
            )
        lines.append(" ".join(f"{v:.7f}" for v in row))
    return "\n".join(lines) + "\n"
