"""The ball: an obstacle that a person carries about."""

import numpy as np

from controllers.kinematics import Array
from scenes.arm_tasks.arm_task import Memory
from scenes.guide import FOLLOW_GAIN, SMOOTHING_TIME, shortened
from scenes.settings import RunSettings
from scenes.targets import BallTarget, Target
from scenes.world import World


class BallTask:
    """Goes where the person wants it, at no more than a person's speed.

    Args:
        world: a room with a ball.
    """

    def __init__(self, world: World) -> None:
        columns = world.room.ball
        assert columns is not None
        self.joints = columns
        self.squared_error = 0.0
        self.desired: Array | None = None
        self.task_jacobian: Array | None = None
        self._positions = world.positions[columns]
        self._box = world.bounds.part(columns)
        self._velocities = np.zeros(3)

    def begin(self) -> None:
        """Come to rest."""
        self._velocities[:] = 0.0

    def nominal(self, target: Target | None, settings: RunSettings, time: float) -> Array:
        """Return the ball's velocity (3,) [m/s]; the array is reused."""
        del time
        wanted: Array | float = 0.0
        if isinstance(target, BallTarget):
            wanted = shortened((target.position - self._positions) * FOLLOW_GAIN, settings.hand_speed)
        v = self._velocities
        v += (wanted - v) * (settings.dt / (SMOOTHING_TIME + settings.dt))
        v[:] = self._box.clip(v)
        return v

    def memory(self) -> Memory:
        """Return the ball's velocity."""
        return (self._velocities.copy(),)

    def remember(self, memory: Memory) -> None:
        """Go on with this velocity."""
        self._velocities[:] = memory[0]
