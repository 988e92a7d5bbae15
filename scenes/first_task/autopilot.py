"""A person who shows each first task with the wall or the hand."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from controllers.kinematics import Array
from scenes.first_task.place import WALL_START
from scenes.quantities import ALL, SINGULAR, STOPS, TIP, WALL
from scenes.roles import Scripted
from scenes.targets import HandTarget, Target, WallTarget, quintic

SPEED: Final = 0.22
"""Peak speed of a move [m/s]."""

REST: Final = 0.8
"""Rest after each move [s]."""

SPREAD: Final = 0.04
"""Largest random shift of each place [m]."""

HAND_PLACES: Final[dict[str, tuple[tuple[float, float, float], ...]]] = {
    WALL: ((0.35, 0.0, -0.10), (0.0, 0.25, 0.0)),
    STOPS: ((-0.20, 0.0, -0.25), (-0.10, -0.35, -0.30)),
    SINGULAR: ((0.75, 0.0, 0.10), (0.30, 0.60, 0.30)),
    TIP: ((0.20, 0.75, -0.20), (0.60, -0.40, -0.10)),
    ALL: ((0.60, 0.55, -0.10), (-0.20, 0.0, -0.25)),
}
"""First task → forbidden places of the hand, from its start (3,) [m]."""

WALL_WAYS: Final = ((-0.42, 0.0, 0.0, 0.0, 0.0), (-0.30, 0.25, 0.0, 0.45, 0.25))
"""Places of the wall that push the arm, from its start (5,) [m, rad]."""


class FirstTaskAutopilot:
    """Quintics from rest to rest, by turns to a forbidden place and back; for times ≥ 0 in any order.

    Args:
        first: see `scenes.quantities`.
        hand: at time 0 (3,), world [m].
    """

    def __init__(self, first: str, seed: int, hand: Array) -> None:
        random, wall = np.random.default_rng(seed), np.array(WALL_START)
        ways: list[tuple[bool, Array, Array]] = []
        hands = [hand + np.array(place) + random.uniform(-SPREAD, SPREAD, 3) for place in HAND_PLACES[first]]
        if first in (WALL, ALL):
            for way, place in zip(WALL_WAYS, hands, strict=True):
                pushed = wall + np.array(way)
                ways += [
                    (True, wall, pushed),
                    (True, pushed, wall),
                    (False, hand, place),
                    (False, place, hand),
                ]
        else:
            for place in hands:
                ways += [(False, hand, place), (False, place, hand)]
        self._moves = ways
        self._ends = np.cumsum([duration_of(a, b) + REST for _, a, b in ways])

    def target(self, time: float) -> Target:
        time %= float(self._ends[-1])
        i = min(int(np.searchsorted(self._ends, time, side="right")), len(self._moves) - 1)
        of_wall, a, b = self._moves[i]
        begin = 0.0 if i == 0 else float(self._ends[i - 1])
        share, _ = quintic(min((time - begin) / duration_of(a, b), 1.0))
        place = a + (b - a) * share
        return WallTarget(place[:3], place[3:]) if of_wall else HandTarget(place)


def duration_of(a: Sequence[float] | Array, b: Sequence[float] | Array) -> float:
    """Time of a move [s]; a quintic from rest to rest peaks at 15/8 of its mean speed."""
    return max(1.875 * float(np.linalg.norm(np.subtract(b, a)[:3])) / SPEED, 0.5)


def autopilot(first: str, seed: int, hand: Array) -> Scripted:
    """Source of a person who begins at `hand` (3,), world [m]."""
    return Scripted(FirstTaskAutopilot(first, seed, hand).target)
