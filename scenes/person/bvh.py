"""A person from a BVH file, with any of the usual names of joints.

Only directions between joints matter, seen from the torso that they span: unit, vertical axis and place make no difference.
"""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import numpy as np

from controllers.errors import BadInputFile, LazyText
from scenes.person.angles import BodyPoints, body_angles
from scenes.person.bvh_file import BvhFile, load_bvh
from scenes.person.source import SampledAngles
from scenes.settings import ArmName

ELBOWS: Final = frozenset({"forearm", "lowerarm", "lowarm", "elbow", "foarm", "radius"})
UPPER_ARMS: Final = frozenset({"arm", "upperarm", "uparm", "shldr", "shoulder", "humerus"})
COLLARS: Final = frozenset({"clavicle", "collar", "collarbone", "shoulderblade", "scapula"})
WRISTS: Final = frozenset({"hand", "wrist", "palm"})
THIGHS: Final = frozenset({"upleg", "upperleg", "thigh", "hip", "leg", "femur", "hipjoint"})
HIPS: Final = ("hips", "hip", "pelvis", "root", "lowerback", "spine")

ADVICE: Final = LazyText(
    "joints are found by names such as LeftForeArm, lForeArm, L_LowerArm, forearm.L, left_elbow; rename yours"
)

_MISSING: Final[dict[tuple[ArmName, str], LazyText]] = {
    ("left", "elbow"): LazyText("left elbow"),
    ("right", "elbow"): LazyText("right elbow"),
    ("left", "upper arm"): LazyText("left upper arm, from which the left elbow should hang"),
    ("right", "upper arm"): LazyText("right upper arm, from which the right elbow should hang"),
    ("left", "wrist"): LazyText("left wrist, which should hang from the left elbow"),
    ("right", "wrist"): LazyText("right wrist, which should hang from the right elbow"),
}
"""What may be missing, each in whole words: another language turns the side with the noun."""

_SIDES: Final[dict[str, ArmName]] = {"left": "left", "l": "left", "right": "right", "r": "right"}

_PARTS: Final = ELBOWS | UPPER_ARMS | COLLARS | WRISTS | THIGHS

_DECORATION: Final = frozenset({"bip", "biped", "bone", "b", "def", "j", "jnt", "joint", "mixamorig", "rig", "character", "skel"})


def read_bvh(source: Path | bytes, name: str = "") -> SampledAngles:
    """Return the motion of both arms in a BVH file, which starts at time 0.

    Args:
        source: a path, or the file's content.
        name: of the file in messages, if its content is given.

    Raises:
        BadInputFile: no such file, or not such a file; names the line, or the joints that were not found, and the remedy.
    """
    file = load_bvh(source, name)
    skeleton = _Skeleton(file)
    places = file.positions({*skeleton.arm["left"], *skeleton.arm["right"], *skeleton.hips})
    shoulders, elbows, wrists = (
        np.stack([places[skeleton.arm[side][i]] for side in ("left", "right")], axis=1) for i in range(3)
    )
    hips = np.mean([places[i] for i in skeleton.hips], axis=0)
    table = np.empty((len(file.frames), 2, 4))
    previous, first = None, len(table)
    for k, points in enumerate(map(BodyPoints, shoulders, elbows, wrists, hips)):
        angles = body_angles(points, previous)
        if angles is not None:
            previous, first = angles, min(first, k)
        if previous is not None:
            table[k] = previous
    if first == len(table):
        raise BadInputFile(
            "{name}: in no frame do hips, shoulders, elbows and wrists make a body; {advice}.", name=file.name, advice=ADVICE
        )
    table[:first] = table[first]
    return SampledAngles(np.arange(len(table), dtype=np.float64) * file.frame_time, table)


def joint_part(name: str) -> tuple[ArmName | None, str]:
    """Return the side that a joint's name tells, and which part of the body it calls it, in lower case without decoration."""
    words = [w.lower() for w in re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+", name.rsplit(":", 1)[-1])]
    words = [w for w in words if w not in _DECORATION] or words
    for i, word in enumerate(words):
        if word in _SIDES:
            return _SIDES[word], "".join(words[i + 1 :] or words[:i])
    part = "".join(words)
    for word, side in _SIDES.items():
        if part.startswith(word) and part.removeprefix(word) in _PARTS:
            return side, part.removeprefix(word)
        if part.endswith(word) and part.removesuffix(word) in _PARTS:
            return side, part.removesuffix(word)
    return None, part


class _Skeleton:
    """Where arms and hips are among the joints of a file; the elbow is found by its name, the upper arm as what it hangs on.

    Attributes:
        arm: indices of shoulder, elbow and wrist of a side.
        hips: indices of the joints between which the middle of the hips is.
    """

    def __init__(self, file: BvhFile) -> None:
        self._file = file
        self._parts = [joint_part(joint.name) for joint in file.joints]
        self.arm: dict[ArmName, tuple[int, int, int]] = {"left": self._find_arm("left"), "right": self._find_arm("right")}
        self.hips = self._find_hips()

    def _find_arm(self, side: ArmName) -> tuple[int, int, int]:
        elbow = self._named(side, ELBOWS)
        if elbow is None:
            raise self._missing(_MISSING[side, "elbow"])
        shoulder = self._file.joints[elbow].parent
        while shoulder >= 0 and self._is_twist(shoulder):
            shoulder = self._file.joints[shoulder].parent
        if shoulder < 0 or self._parts[shoulder][0] != side or self._parts[shoulder][1] in COLLARS:
            raise self._missing(_MISSING[side, "upper arm"])
        wrist = next((i for i in self._below(elbow) if self._parts[i][1] in WRISTS), None)
        if wrist is None:
            wrist = next((i for i in self._below(elbow) if not self._is_twist(i)), None)
        if wrist is None:
            raise self._missing(_MISSING[side, "wrist"])
        return shoulder, elbow, wrist

    def _find_hips(self) -> tuple[int, ...]:
        left, right = self._named("left", THIGHS), self._named("right", THIGHS)
        if left is not None and right is not None:
            return left, right
        for name in HIPS:
            for i, (side, part) in enumerate(self._parts):
                if side is None and part == name:
                    return (i,)
        raise self._missing(LazyText("hips"))

    def _named(self, side: ArmName, parts: frozenset[str]) -> int | None:
        return next((i for i, (s, part) in enumerate(self._parts) if s == side and part in parts), None)

    def _is_twist(self, joint: int) -> bool:
        part = self._parts[joint][1]
        return "twist" in part or "roll" in part

    def _below(self, joint: int) -> Iterator[int]:
        """Yield all that hangs on a joint, parents first."""
        found = {joint}
        for i, other in enumerate(self._file.joints):
            if other.parent in found:
                found.add(i)
                yield i

    def _missing(self, what: LazyText) -> BadInputFile:
        names = [joint.name for joint in self._file.joints if joint.name]
        shown = ", ".join(repr(n[:30]) for n in names[:8]) + (" …" if len(names) > 8 else "")
        return BadInputFile(
            "{name}: the skeleton has no {what}. It has {joints}; {advice}.",
            name=self._file.name,
            what=what,
            joints=shown,
            advice=ADVICE,
        )
