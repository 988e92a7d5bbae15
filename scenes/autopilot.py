"""A seeded, random "person" who moves the guided arm the way the paper's human did: towards the other arm and back, again and again."""

from typing import Final

import numpy as np

from controllers.kinematics import Array, Kinematics
from scenes.room import Room
from scenes.settings import ArmName
from scenes.targets import HandTarget

SPEED_RANGE: Final = (0.10, 0.22)
"""Peak speed of a move [m/s]."""

PAUSE_RANGE: Final = (0.4, 1.2)
"""Rest between two moves [s]."""


class Autopilot:
    """The wanted position of the guided hand at any time, a pure function of the seed: quintics from rest to rest, by turns to a random
    place on the other arm, as it stood at the start, and to one near home.

    Args:
        guided: the arm that the person holds.
        seed: which person.
        start: where the hand is at time 0 (3,) [m]; None for its place in the rig's start posture.
    """

    def __init__(self, room: Room, guided: ArmName, seed: int, start: Array | None = None) -> None:
        kinematics = Kinematics(room.model, room.arms)
        kinematics.update(room.start)
        other = room.other(guided)
        elbow, wrist = kinematics.joint_point(other.elbow), kinematics.joint_point(other.wrist)
        hand = kinematics.hand_pose(other).translation.copy()
        self._places = (hand, wrist, (elbow + wrist) / 2.0)
        self._home = kinematics.hand_pose(room.arm(guided)).translation.copy()
        self._random = np.random.default_rng(seed)
        self._begin = self._home if start is None else np.array(start, float)
        # Knots of the way so far: time the move starts, its duration, from, to.
        self._moves: list[tuple[float, float, Array, Array]] = []
        self._end = 0.0

    def target(self, time: float) -> HandTarget:
        """Return where the hand should be at a time ≥ 0 [s]. Times may be asked for in any order."""
        while self._end <= time:
            self._plan_move()
        move = self._moves[-1]
        if move[0] > time:
            move = next(move for move in reversed(self._moves) if move[0] <= time)
        start, duration, a, b = move
        share, _ = quintic(min((time - start) / duration, 1.0))
        return HandTarget(a + (b - a) * share)

    def _plan_move(self) -> None:
        random = self._random
        a = self._moves[-1][3] if self._moves else self._begin
        if len(self._moves) % 2 == 0:
            b = self._places[random.integers(len(self._places))] + random.uniform(-0.06, 0.06, 3)
        else:
            b = self._home + random.uniform(-0.10, 0.10, 3)
        # A quintic from rest to rest peaks at 15/8 of its mean speed.
        duration = max(1.875 * float(np.linalg.norm(b - a)) / random.uniform(*SPEED_RANGE), 0.5)
        self._moves.append((self._end, duration, a, b))
        self._end += duration + random.uniform(*PAUSE_RANGE)


def quintic(s: float) -> tuple[float, float]:
    """Return the share of a way from rest to rest that is done at s in [0, 1] of its time, and its derivative by s."""
    return s * s * s * (10.0 + s * (6.0 * s - 15.0)), 30.0 * s * s * (1.0 - s) * (1.0 - s)
