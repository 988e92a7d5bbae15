"""Writes BVH files out of a person's angles, the way different programs would."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from controllers.kinematics import Array
from scenes.person.angles import SIGN, arm_rotation
from scenes.person.source import PersonSource
from scenes.settings import ArmName
from tests.scenes.person.strategies import SIDES

Axes = tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]]

Y_UP: Axes = ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
"""From the torso frame to a file with y up that looks along z."""

Z_UP: Axes = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True)
class Style:
    """A program's habits.

    Attributes:
        hips, spine, collar, shoulder, elbow, wrist, thigh: names of joints; "{}" stands for the side. Without a collar the upper arm
            hangs on the spine; without a wrist the forearm ends in an End Site.
        sides: what it calls left and right.
        order: of the rotation channels.
        axes: from the torso frame to the file's.
        unit: file units in a metre.
        rest: angles of an arm in the skeleton's rest posture [deg].
        all_positions: write position channels for every joint, as zeros.
        roll: what names of joints halfway down a bone end in, which twist it; "" for none.
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
    "root", "spine", "", "{}_shoulder", "{}_elbow", "", "", ("left", "right"), "YXZ", Z_UP, 39.37, (0.0, 90.0, 0.0, 0.0), True
)
UNDERSCORE = Style("Pelvis", "Spine", "{}_Collar", "{}_UpperArm", "{}_LowerArm", "{}_Hand", "{}_Thigh", ("L", "R"), "ZYX")

STYLES = {"mixamo": MIXAMO, "twisted": TWISTED, "poser": POSER, "blender": BLENDER, "snake": SNAKE, "underscore": UNDERSCORE}


def write_bvh(source: PersonSource, style: Style, frames: int = 60, frame_time: float = 0.05, seed: int = 1) -> str:
    writer = _Writer(style)
    random = np.random.default_rng(seed)
    drift = random.uniform(-0.3, 0.3, 3)
    rows = []
    for k in range(frames):
        t = k * frame_time
        angles = source.angles(t)
        assert angles is not None
        body = Rotation.from_euler("zyx", drift * t).as_matrix()
        rows.append(writer.frame(angles, body, drift * t))
    lines = ["HIERARCHY", *writer.lines, "MOTION", f"Frames: {frames}", f"Frame Time: {frame_time}"]
    return "\n".join(lines + [" ".join(f"{v:.7f}" for v in row) for row in rows]) + "\n"


class _Writer:
    def __init__(self, style: Style) -> None:
        self.style, self.lines, self.names = style, [], []
        self._rest = arm_rotation(np.radians(style.rest), "left"), arm_rotation(np.radians(style.rest), "right")
        self._open("ROOT", style.hips, (0.0, 0.0, 0.0))
        for i, y in enumerate((0.1, -0.1)):
            if style.thigh:
                self._open("JOINT", style.thigh.format(style.sides[i]), (0.0, y, 0.0))
                self._end((0.0, 0.0, -0.8))
                self._close()
        self._open("JOINT", style.spine, (0.0, 0.0, 0.2))
        for side, word in zip(SIDES, style.sides, strict=True):
            self._arm(side, SIGN[side], word)
        self._close()
        self._close()

    def _arm(self, side: ArmName, sign: float, word: str) -> None:
        style = self.style
        rest = self._rest[0 if side == "left" else 1]
        e = np.radians(style.rest[3])
        down, out = rest @ [0.0, 0.0, -1.0], rest @ [np.sin(e), 0.0, -np.cos(e)]
        if style.collar:
            self._open("JOINT", style.collar.format(word), (0.0, 0.05 * sign, 0.3))
            self._open("JOINT", style.shoulder.format(word), (0.0, 0.15 * sign, 0.0))
        else:
            self._open("JOINT", style.shoulder.format(word), (0.0, 0.2 * sign, 0.3))
        self._bone(style.shoulder, style.elbow, word, 0.31 * down)
        if style.wrist:
            self._bone(style.elbow, style.wrist, word, 0.26 * out)
            self._end(0.1 * out)
        else:
            self._end(0.26 * out)
        for _ in range(2 + bool(style.collar) + bool(style.wrist) + 2 * bool(style.roll)):
            self._close()

    def _bone(self, start: str, end: str, word: str, way: Array) -> None:
        if self.style.roll:
            self._open("JOINT", start.format(word) + self.style.roll, way / 2.0)
            way = way / 2.0
        self._open("JOINT", end.format(word), way)

    def _open(self, kind: str, name: str, offset: object) -> None:
        rotations = " ".join(f"{axis}rotation" for axis in self.style.order)
        positions = "Xposition Yposition Zposition "
        full = kind == "ROOT" or self.style.all_positions
        channels = f"CHANNELS 6 {positions}{rotations}" if full else f"CHANNELS 3 {rotations}"
        self.lines += [f"{kind} {name}", "{", self._offset(offset), channels]
        self.names.append((kind, name, full))

    def _end(self, offset: object) -> None:
        self.lines += ["End Site", "{", self._offset(offset), "}"]

    def _close(self) -> None:
        self.lines.append("}")

    def _offset(self, offset: object) -> str:
        x, y, z = np.array(self.style.axes) @ np.asarray(offset, float) * self.style.unit
        return f"OFFSET {x:.6f} {y:.6f} {z:.6f}"

    def frame(self, angles: Array, body: Array, place: Array) -> list[float]:
        C, style = np.array(self.style.axes), self.style
        local = {style.hips: body}
        for i, side in enumerate(SIDES):
            rest, word = self._rest[i], style.sides[i]
            R = arm_rotation(angles[i], side)
            bend = Rotation.from_euler("y", -(angles[i, 3] - np.radians(style.rest[3]))).as_matrix()
            # The forearm's rest direction is bent already, about the rest arm's own y.
            upper, forearm = R @ rest.T, R @ bend @ rest.T
            local[style.shoulder.format(word)] = upper
            local[style.elbow.format(word)] = upper.T @ forearm
        row: list[float] = []
        for kind, name, full in self.names:
            if full:
                row += (C @ place * style.unit).tolist() if kind == "ROOT" else [0.0, 0.0, 0.0]
            turn = C @ local.get(name, np.eye(3)) @ C.T
            row += Rotation.from_matrix(turn).as_euler(style.order, degrees=True).tolist()
        return row
