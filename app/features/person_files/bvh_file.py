"""BVH: a tree of joints, then a line of numbers per frame. Nothing in the file is trusted."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from controllers.errors import BadInputFile, LazyText
from controllers.kinematics import Array
from scenes.files import input_content

MOST_BYTES: Final = 32_000_000
MOST_JOINTS: Final = 500
MOST_FRAMES: Final = 100_000
MOST_LINES: Final = 2 * MOST_FRAMES + 20 * MOST_JOINTS
LARGEST: Final = 1e6
"""Largest believable number, in any unit."""

CHANNELS: Final = ("xposition", "yposition", "zposition", "xrotation", "yrotation", "zrotation")


@dataclass(frozen=True)
class BvhJoint:
    """A joint, or the end of a chain.

    Attributes:
        name: "" for an end.
        parent: index; −1 for a root. Parents come before children.
        offset: from the parent (3,), file units.
        channels: indices into `CHANNELS`, in the file's order.
        column: of its first channel in a frame.
    """

    name: str
    parent: int
    offset: Array
    channels: tuple[int, ...]
    column: int


@dataclass(frozen=True)
class BvhFile:
    """`frame_time`: [s]; `frames`: (k, channels), file units and degrees."""

    name: str
    joints: tuple[BvhJoint, ...]
    frame_time: float
    frames: Array

    def positions(self, wanted: set[int]) -> dict[int, Array]:
        """Positions (k, 3) of wanted joints and ancestors, in the file's frame and unit."""
        needed: set[int] = set()
        for joint in wanted:
            while joint >= 0:
                needed.add(joint)
                joint = self.joints[joint].parent
        places: dict[int, Array] = {}
        turns: dict[int, Array] = {}
        for i in sorted(needed):
            joint = self.joints[i]
            place, turn = self._translations(joint), self._rotations(joint)
            if joint.parent >= 0:
                parent_turn = turns[joint.parent]
                place = places[joint.parent] + np.einsum("kij,kj->ki", parent_turn, place)
                turn = parent_turn @ turn
            places[i], turns[i] = place, turn
        return places

    def _translations(self, joint: BvhJoint) -> Array:
        """From the parent (k, 3): position channels, or the offset if all are zero, which some exporters
        write.
        """
        place = np.tile(joint.offset, (len(self.frames), 1))
        moved = [(c, joint.column + i) for i, c in enumerate(joint.channels) if c < 3]
        if any(self.frames[:, column].any() for _, column in moved):
            for axis, column in moved:
                place[:, axis] = self.frames[:, column]
        return place

    def _rotations(self, joint: BvhJoint) -> Array:
        """Against the parent (k, 3, 3): rotation channels in the file's order."""
        turn = np.tile(np.eye(3), (len(self.frames), 1, 1))
        for i, channel in enumerate(joint.channels):
            if channel >= 3:
                angle = np.radians(self.frames[:, joint.column + i])
                one = np.tile(np.eye(3), (len(angle), 1, 1))
                j, k = (channel - 2) % 3, (channel - 1) % 3
                one[:, j, j] = one[:, k, k] = np.cos(angle)
                one[:, k, j] = np.sin(angle)
                one[:, j, k] = -one[:, k, j]
                turn = turn @ one
        return turn


def load_bvh(source: Path | bytes, name: str = "") -> BvhFile:
    """Arguments and errors as `app.features.person_files.bvh.read_bvh`."""
    if isinstance(source, Path):
        name = str(source)
        missing = BadInputFile("{name}: there is no such file; give the path of a BVH file.", name=name)
        source = input_content(source, MOST_BYTES, missing, _too_large(name))
    name = name or LazyText("The BVH file")
    if len(source) > MOST_BYTES:
        raise _too_large(name)
    # Of the separators that `splitlines` knows, only these end a line for a person who looks up its number.
    text = source.decode("utf-8-sig", errors="replace").replace("\r\n", "\n").replace("\r", "\n")
    if text.count("\n") > MOST_LINES:
        raise _too_large(name)
    return _Reader(name, text).read()


def _too_large(name: str) -> BadInputFile:
    return BadInputFile(
        "{name}: is larger than {size} MB or {lines} lines; cut it, or export it at fewer frames a second.",
        name=name,
        size=MOST_BYTES // 1_000_000,
        lines=MOST_LINES,
    )


class _Reader:
    def __init__(self, name: str, text: str) -> None:
        self.name = name
        # A brace may be at the end of a line or on its own.
        self.lines: list[tuple[int, str]] = []
        for number, line in enumerate(text.split("\n"), 1):
            line = line.strip()
            if line.endswith("{") and line != "{":
                self.lines += [(number, line[:-1].strip()), (number, "{")]
            elif line:
                self.lines.append((number, line))
        self.at = 0
        self.number = 1
        self.joints: list[BvhJoint] = []
        self.columns = 0

    def read(self) -> BvhFile:
        if not self.lines or self._next("HIERARCHY").upper() != "HIERARCHY":
            raise self._fault(
                "is not a BVH file, which begins with the word HIERARCHY; export the motion as BVH"
            )
        while self.at >= len(self.lines) or self.lines[self.at][1].upper() != "MOTION":
            kind, *rest = self._next(LazyText("ROOT or MOTION")).split(None, 1)
            if kind.upper() != "ROOT" or not rest:
                raise self._fault("{word} instead of ROOT and a name, or MOTION", word=_shown(kind))
            self._read_tree(rest[0])
        self._next("MOTION")
        count, frame_time = self._read_head()
        return BvhFile(self.name, tuple(self.joints), frame_time, self._read_frames(count))

    def _read_tree(self, root: str) -> None:
        """Without recursion, as a file may be arbitrarily deep."""
        open_joints = [self._read_joint(root, -1)]
        while open_joints:
            line = self._next(LazyText("JOINT, End Site or }"))
            kind, *rest = line.split(None, 1)
            if kind == "}":
                open_joints.pop()
            elif kind.upper() == "JOINT" and rest:
                open_joints.append(self._read_joint(rest[0], open_joints[-1]))
            elif line.upper().split() == ["END", "SITE"]:
                open_joints.append(self._read_joint("", open_joints[-1]))
            else:
                raise self._fault("{word} instead of JOINT and a name, End Site or }}", word=_shown(line))

    def _read_joint(self, name: str, parent: int) -> int:
        if len(self.joints) >= MOST_JOINTS:
            raise self._fault(
                "the skeleton has more than {most} joints; export the body only", most=MOST_JOINTS
            )
        if self._next("{") != "{":
            raise self._fault("{ is missing")
        offset = self._words("OFFSET", 3)
        channels: tuple[int, ...] = ()
        if name:
            count, *names = self._words("CHANNELS", None)
            channels = tuple(CHANNELS.index(n.lower()) for n in names if n.lower() in CHANNELS)
            if count != str(len(names)) or len(channels) != len(names) or len(set(channels)) != len(channels):
                raise self._fault(
                    "CHANNELS needs their number and as many different names out of Xposition … Zrotation"
                )
        self.joints.append(
            BvhJoint(name, parent, np.array([self._number(w) for w in offset]), channels, self.columns)
        )
        self.columns += len(channels)
        return len(self.joints) - 1

    def _read_head(self) -> tuple[int, float]:
        words = self._next("Frames:").replace(":", ": ").split()
        if len(words) != 2 or words[0].lower() != "frames:" or not words[1].isdecimal() or len(words[1]) > 12:
            raise self._fault("must be Frames: and a whole number")
        count = int(words[1])
        if not 1 <= count <= MOST_FRAMES:
            raise self._fault(
                "{count} frames cannot be read; give 1 to {most}, or export fewer frames a second",
                count=count,
                most=MOST_FRAMES,
            )
        words = self._next("Frame Time:").replace(":", ": ").split()
        if len(words) != 3 or [w.lower() for w in words[:2]] != ["frame", "time:"]:
            raise self._fault("must be Frame Time: and a number of seconds")
        frame_time = self._number(words[2])
        if not 1e-4 <= frame_time <= 10.0:
            raise self._fault(
                "a frame time of {time:g} s is not believable; give 0.0001 to 10 s", time=frame_time
            )
        return count, frame_time

    def _read_frames(self, count: int) -> Array:
        rows = self.lines[self.at :]
        if len(rows) != count:
            self.number = rows[min(count, len(rows) - 1)][0] if rows else self.number
            raise self._fault(
                "{there} frames follow, but Frames: says {count}; the file is damaged, export it again",
                there=len(rows),
                count=count,
            )
        # Memory for many numbers is reserved only once a line has the promised length.
        table = (
            np.empty((count, self.columns)) if len(rows[0][1].split()) == self.columns else np.empty((0, 0))
        )
        for i, (self.number, line) in enumerate(rows):
            words = line.split()
            if len(words) != self.columns:
                raise self._fault(
                    "{there} numbers in this line, but the skeleton has {columns} channels; export it again",
                    there=len(words),
                    columns=self.columns,
                )
            table[i] = [self._number(word) for word in words]
        return table

    def _next(self, due: str) -> str:
        if self.at >= len(self.lines):
            raise self._fault(
                "the file ends where {due} is due; it is not complete, export it again", due=due
            )
        self.number, line = self.lines[self.at]
        self.at += 1
        return line

    def _words(self, first: str, count: int | None) -> list[str]:
        words = self._next(first).split()
        if words[0].upper() != first or len(words) < 2 or count not in (None, len(words) - 1):
            if count is None:
                raise self._fault("{word} and its values are expected here", word=first)
            raise self._fault("{word} and {count} numbers are expected here", word=first, count=count)
        return words[1:]

    def _number(self, word: str) -> float:
        try:
            value = float(word)
        except ValueError:
            raise self._fault("{word} is not a number", word=_shown(word)) from None
        if not math.isfinite(value):
            raise self._fault("{word} is not a finite number; export it again", word=_shown(word))
        if abs(value) > LARGEST:
            raise self._fault(
                "{word} is not believable; no number may be larger than {most:g}",
                word=_shown(word),
                most=LARGEST,
            )
        return value

    def _fault(self, what: str, /, **parts: object) -> BadInputFile:
        return BadInputFile(
            "{name}, line {number}: {what}.", name=self.name, number=self.number, what=LazyText(what, **parts)
        )


def _shown(text: str) -> str:
    return repr(text if len(text) <= 40 else text[:37] + "…")
