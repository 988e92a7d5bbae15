"""Targets as numbers, bit for bit."""

from collections.abc import Iterator
from itertools import chain, product, repeat
from typing import Final, NamedTuple, cast

import numpy as np

from controllers.kinematics import Array
from scenes.targets import (
    AnglesTarget,
    BallTarget,
    HandTarget,
    HeldTarget,
    JointTarget,
    LinkTarget,
    PairTarget,
    Target,
    WallTarget,
)

NOTHING: Final = 0
HAND: Final = 1
"""Plus `ROTATION` or `TURNED` with a rotation, plus `ELBOW` with an elbow."""
ROTATION: Final = 2
TURNED: Final = 4
"""A rotation stored by columns: products with it may have other last bits."""
ELBOW: Final = 8
BALL: Final = 16
UNSEEN: Final = 17
ANGLES: Final = 18
LINK: Final = 19
"""Joint, offset, position."""
WALL: Final = 20
"""Position, turn and tilt."""
JOINTS: Final = 64
"""Plus the number of joints."""

MOST_JOINTS: Final = 32
PAIR: Final = 128
"""Plus the index of the pair in `KINDS`."""

_HANDS: Final = {
    HAND + turn + elbow: 3 + (9 if turn else 0) + (3 if elbow else 0)
    for turn in (0, ROTATION, TURNED)
    for elbow in (0, ELBOW)
}
WIDTHS: Final[dict[int, int]] = {
    NOTHING: 0,
    BALL: 3,
    UNSEEN: 0,
    ANGLES: 8,
    LINK: 7,
    WALL: 5,
    **_HANDS,
    **{JOINTS + n: n for n in range(1, MOST_JOINTS + 1)},
}

KINDS: Final[dict[int, tuple[int, ...]]] = {
    **{code: (code,) for code in WIDTHS},
    **dict(
        enumerate(
            # Codes never change: files have them.
            chain(
                product((NOTHING, LINK, *sorted(_HANDS)), (LINK, *sorted(_HANDS))),
                product((WALL,), (LINK, *sorted(_HANDS))),
            ),
            start=PAIR,
        )
    ),
}
"""Code → kinds of its one or two targets; the second one's numbers follow."""
WIDTHS.update({code: sum(WIDTHS[kind] for kind in kinds) for code, kinds in KINDS.items()})
_CODE_OF: Final = {kinds: code for code, kinds in KINDS.items()}

WIDTH: Final = np.array([WIDTHS.get(code, 0) for code in range(256)], np.int64)
"""`WIDTHS` as an array (256,), 0 without a code."""


class PackedTargets(NamedTuple):
    """One target per step, equal neighbours stored once; read only.

    Attributes:
        codes: (k,) kinds.
        counts: (k,) steps.
        numbers: of all targets, concatenated (n,) [m, rad], `WIDTHS` of each.
    """

    codes: np.ndarray
    counts: np.ndarray
    numbers: Array

    @property
    def steps(self) -> int:
        return int(self.counts.sum())

    @property
    def offsets(self) -> np.ndarray:
        """Start of each target's numbers (k,)."""
        widths = WIDTH[self.codes]
        return np.cumsum(widths) - widths

    def runs(self) -> Iterator[tuple[Target | None, int]]:
        numbers, begin = self.numbers, 0
        for code, count in zip(self.codes.tolist(), self.counts.tolist(), strict=True):
            end = begin + WIDTHS[code]
            yield decoded(code, numbers[begin:end]), count
            begin = end

    def each(self) -> Iterator[Target | None]:
        for target, count in self.runs():
            yield from repeat(target, count)

    def since(self, step: int) -> "PackedTargets":
        ends = np.cumsum(self.counts)
        first = int(np.searchsorted(ends, step, side="right"))
        counts = self.counts[first:].copy()
        counts[0] = ends[first] - step
        return PackedTargets(self.codes[first:], counts, self.numbers[self.offsets[first] :])


def joined_targets(parts: list[PackedTargets]) -> PackedTargets:
    if len(parts) == 1:
        return parts[0]
    return PackedTargets(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))


def encoded(target: Target | None) -> tuple[int, bytes]:
    """Kind and numbers of a target."""
    if target is None:
        return NOTHING, b""
    if isinstance(target, HandTarget):
        position, rotation, elbow = target
        code, numbers = HAND, np.asarray(position, np.float64).tobytes()
        if rotation is not None:
            rotation = np.asarray(rotation, np.float64)
            code += TURNED if rotation.flags.fnc else ROTATION
            numbers += rotation.tobytes("A")
        if elbow is not None:
            code += ELBOW
            numbers += np.asarray(elbow, np.float64).tobytes()
        return code, numbers
    if isinstance(target, AnglesTarget):
        return (
            (UNSEEN, b"")
            if target.angles is None
            else (ANGLES, np.asarray(target.angles, np.float64).tobytes())
        )
    if isinstance(target, BallTarget):
        return BALL, np.asarray(target.position, np.float64).tobytes()
    if isinstance(target, WallTarget):
        return WALL, np.concatenate([target.position, target.turn]).tobytes()
    if isinstance(target, LinkTarget):
        return LINK, np.array([target.joint, *target.offset, *target.position], np.float64).tobytes()
    if isinstance(target, PairTarget):
        (first, numbers), (second, more) = encoded(target.first), encoded(target.second)
        return _CODE_OF[first, second], numbers + more
    positions = np.asarray(target.positions, np.float64)
    return JOINTS + len(positions), positions.tobytes()


def decoded(code: int, numbers: Array) -> Target | None:
    """Target of a kind with these numbers (`WIDTHS[code]`,); its arrays are views of them."""
    if code == NOTHING:
        return None
    if code == UNSEEN:
        return AnglesTarget(None)
    if code == ANGLES:
        return AnglesTarget(numbers.reshape(2, 4))
    if code == BALL:
        return BallTarget(numbers)
    if code == WALL:
        return WallTarget(numbers[:3], numbers[3:])
    if code == LINK:
        return LinkTarget(int(numbers[0]), numbers[1:4], numbers[4:])
    if code >= PAIR:
        first, second = KINDS[code]
        held = decoded(first, numbers[: WIDTHS[first]]), decoded(second, numbers[WIDTHS[first] :])
        return PairTarget(*cast(tuple[HeldTarget | WallTarget | None, HeldTarget], held))
    if code > JOINTS:
        return JointTarget(numbers)
    rotation = elbow = None
    if code & (ROTATION | TURNED):
        rotation = numbers[3:12].reshape((3, 3), order="F" if code & TURNED else "C")
    if code & ELBOW:
        elbow = numbers[-3:]
    return HandTarget(numbers[:3], rotation, elbow)


def planes_of(rows: Array) -> np.ndarray:
    """Numbers (k, columns) as bytes (columns, 8, k) for a compressor: XOR of consecutive rows."""
    bits = np.ascontiguousarray(rows.T, "<f8").view("<u8")
    change = bits.copy()
    change[:, 1:] ^= bits[:, :-1]
    return np.ascontiguousarray(change.view(np.uint8).reshape(*bits.shape, 8).transpose(0, 2, 1))


def rows_of(planes: np.ndarray) -> Array:
    change = np.ascontiguousarray(planes.transpose(0, 2, 1)).view("<u8")[..., 0]
    return np.ascontiguousarray(np.bitwise_xor.accumulate(change, axis=1).view("<f8").T)
