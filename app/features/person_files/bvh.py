"""A person from a BVH file.

Only directions between joints relative to the torso matter, not unit, vertical axis or position.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Final

import numpy as np

from app.features.person_files.bvh_file import BvhFile, load_bvh
from app.features.person_files.joint_names import (
    COLLARS,
    ELBOWS,
    ELBOWS_BELOW_SHOULDERS,
    HIPS,
    SHOULDERS,
    THIGHS,
    UPPER_ARMS,
    WRISTS,
    is_twist,
    joint_part,
)
from controllers.errors import BadInputFile, LazyText
from scenes.person.angles import BodyPoints, body_angles
from scenes.person.source import PersonTarget, SampledAngles
from scenes.settings import ArmName

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
"""Whole words: in another language the side is inflected with the noun."""


def read_bvh(source: Path | bytes, name: str = "") -> SampledAngles:
    """Motion of both arms, from time 0. `source`: path or content; `name`: for messages about content.

    Raises:
        BadInputFile: unreadable or unsuitable file.
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
            "{name}: in no frame do hips, shoulders, elbows and wrists make a body; {advice}.",
            name=file.name,
            advice=ADVICE,
        )
    table[:first] = table[first]
    return SampledAngles(np.arange(len(table), dtype=np.float64) * file.frame_time, table)


class _Skeleton:
    """Finds arms and hips by names: the wrist is below the elbow, the shoulder farthest above it. Joints
    between them only move them.

    Attributes:
        arm: indices of shoulder, elbow and wrist.
        hips: joints around the middle of the hips.
    """

    def __init__(self, file: BvhFile) -> None:
        self._file = file
        self._parts = [joint_part(joint.name) for joint in file.joints]
        self._twists = [is_twist(joint.name) for joint in file.joints]
        self.arm: dict[ArmName, tuple[int, int, int]] = {
            "left": self._find_arm("left"),
            "right": self._find_arm("right"),
        }
        self.hips = self._find_hips()

    def _find_arm(self, side: ArmName) -> tuple[int, int, int]:
        """First complete arm.

        Raises:
            BadInputFile: no complete arm, or arms of several people.
        """
        called = [i for i, (s, part) in enumerate(self._parts) if s == side and part in ELBOWS]
        named = [i for i in called if not self._twists[i]] or called
        # The first of several pieces of a forearm begins at the elbow.
        elbows = [i for i in named if not any(other in named for other in self._above(i))]
        if not elbows:
            raise self._missing(_MISSING[side, "elbow"])
        found = [(self._shoulder(side, elbow), elbow, self._wrist(elbow)) for elbow in elbows]
        whole = [(s, e, w) for s, e, w in found if s is not None and w is not None]
        if not whole:
            raise self._missing(_MISSING[side, "upper arm" if found[0][0] is None else "wrist"])
        roots = {(self._above(elbow) or [elbow])[-1] for _, elbow, _ in whole}
        if len(roots) > 1:
            raise BadInputFile(
                "{name}: holds {count} people, {joints}; export the motion of one.",
                name=self._file.name,
                count=len(roots),
                joints=", ".join(repr(self._file.joints[i].name[:30]) for i in sorted(roots)[:4]),
            )
        return whole[0]

    def _shoulder(self, side: ArmName, elbow: int) -> int | None:
        above = [i for i in self._above(elbow) if self._parts[i][0] == side]
        for names in UPPER_ARMS:
            if called := [i for i in above if self._parts[i][1] in names]:
                # The first of several pieces of an upper arm begins at the shoulder.
                return next((i for i in reversed(called) if not self._twists[i]), called[-1])
        collars = [i for i in above if self._parts[i][1] in COLLARS]
        if called := [i for i in above if self._parts[i][1] in SHOULDERS]:
            shoulder = called[-1]
            has_collar = any(collar in self._above(shoulder) for collar in collars)
            if has_collar or (
                self._parts[elbow][1] in ELBOWS_BELOW_SHOULDERS and self._are_pieces(shoulder, elbow)
            ):
                return shoulder
        # By its position: the elbow's parent, whatever its name.
        joint = self._file.joints[elbow].parent
        while joint >= 0 and self._twists[joint]:
            joint = self._file.joints[joint].parent
        if joint < 0 or self._parts[joint][0] != side or joint in collars:
            return None
        while (parent := self._file.joints[joint].parent) >= 0 and self._parts[parent] == self._parts[joint]:
            joint = parent
        return joint

    def _are_pieces(self, shoulder: int, elbow: int) -> bool:
        """True if all joints between are twists, or extend the shoulder's name."""
        side, part = self._parts[shoulder]
        between = self._above(elbow)[: self._above(elbow).index(shoulder)]
        return all(
            self._twists[i] or (self._parts[i][0] == side and self._parts[i][1].startswith(part))
            for i in between
        )

    def _wrist(self, elbow: int) -> int | None:
        """Joint, or End Site, where the forearm ends."""
        part = self._parts[elbow][1]
        below = [
            i for i in self._below(elbow) if not self._twists[i] and not self._parts[i][1].startswith(part)
        ]
        called = [i for i in below if self._parts[i][1] in WRISTS]
        return next((i for i in (*called, *(i for i in below if self._file.joints[i].name), *below)), None)

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

    def _above(self, joint: int) -> list[int]:
        found: list[int] = []
        while (joint := self._file.joints[joint].parent) >= 0:
            found.append(joint)
        return found

    def _below(self, joint: int) -> Iterator[int]:
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


def from_bvh(motion: SampledAngles) -> PersonTarget:
    return PersonTarget(motion, max(motion.duration, 1e-3))
