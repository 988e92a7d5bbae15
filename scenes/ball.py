"""A ball in the way (Fig. 1): one arm takes its hand from A to B past an obstacle, and back; with one control point the law is smooth."""

from typing import Final

import numpy as np

from controllers.kinematics import Array
from scenes.arm_tasks.ball_task import BallTask
from scenes.arm_tasks.hold_task import HoldTask
from scenes.autopilot import quintic
from scenes.roles import NoSource, Roles, TargetSource
from scenes.room import PATH
from scenes.settings import RunSettings
from scenes.targets import BallTarget
from scenes.world import World

TRAVEL: Final = 5.0
"""Time from A to B [s]."""

REST: Final = 1.5
"""Rest at either end [s]."""

SWING: Final = 0.25
"""How far the ball goes to either side when it crosses the path [m]."""


def path(time: float, home: Array) -> tuple[Array, Array]:
    """Return where the hand should be (3,) [m] and its velocity (3,) [m/s]: a quintic from A, its home (3,), to B, a rest, and back."""
    period = TRAVEL + REST
    leg, t = divmod(max(time - REST, 0.0), period)
    share, rate = quintic(min(t / TRAVEL, 1.0))
    back = int(leg) % 2 == 1
    return home + PATH * (1.0 - share if back else share), PATH * ((-rate if back else rate) / TRAVEL)


def roles(world: World, settings: RunSettings) -> Roles:
    """Return the roles."""
    del settings
    arm = world.room.arms[0]
    keeper, ball = HoldTask(world, arm, path), BallTask(world)
    return Roles((ball, keeper), arm, arm, keeper, None, (keeper,))


def source(world: World, settings: RunSettings) -> TargetSource:
    """Return the source that moves the ball."""
    if settings.ball == "still":
        return NoSource()
    assert world.room.ball is not None
    return BallSwing(world.room.start[world.room.ball], settings.seed)


class BallSwing:
    """Carries the ball across the path and back, at a pace that the seed chooses. `middle`: of its way (3,) [m]; `seed`: which person."""

    def __init__(self, middle: Array, seed: int) -> None:
        self._middle = middle.copy()
        self._period = float(np.random.default_rng(seed).uniform(7.0, 11.0))

    def target(self, time: float) -> BallTarget:
        """Return where the ball should be at a time [s]."""
        way = np.array([SWING * np.sin(2.0 * np.pi * time / self._period), 0.0, 0.0])
        return BallTarget(self._middle + way)
