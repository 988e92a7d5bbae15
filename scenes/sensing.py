"""What the controller sees: joint sensors with noise and a resolution, and a distance that is measured in frames, with noise.

Noise is a function of seed and step (or frame) alone, so that a run can be resumed anywhere, and what was seen can be computed again.
"""

import numpy as np

from controllers.kinematics import Arm, Array
from controllers.proximity import Proximity
from scenes.arm_tasks.arm_task import Memory
from scenes.settings import HardwareSettings, RunSettings
from scenes.world import World

JOINTS, DISTANCE = 0, 1
"""Streams of random numbers."""


def normal(seed: int, stream: int, index: int, count: int) -> Array:
    """Return standard normal numbers (count,), always the same for the same seed, stream and index ≥ 0."""
    return np.random.Generator(np.random.Philox(key=seed, counter=[0, index, stream, 0])).standard_normal(count)


def measured_positions(settings: RunSettings, positions: Array, arms: tuple[Arm, ...], step: int) -> Array:
    """Return q (nv,) as the joint sensors show it [rad]; whatever is no joint of an arm is shown as it is.

    Args:
        positions: the true q (nv,) [rad].
        step: steps made before.
    """
    hardware, seen = settings.hardware, positions.copy()
    noise = normal(settings.seed, JOINTS, step, len(seen)) * hardware.joint_noise if hardware.joint_noise > 0.0 else None
    for arm in arms:
        if noise is not None:
            seen[arm.joints] += noise[arm.joints]
        if hardware.joint_resolution > 0.0:
            seen[arm.joints] = np.round(seen[arm.joints] / hardware.joint_resolution) * hardware.joint_resolution
    return seen


class Sensing:
    """The distance sensor; it looks at the posture that the joint sensors show. `error`: of the newest distance [m]."""

    def __init__(self, world: World) -> None:
        self._world = world
        self.clear()

    def clear(self) -> None:
        """Forget the last frame."""
        self.error = 0.0
        self._frame = -1
        self._held = np.empty(0)

    def proximity(self, settings: RunSettings, actual: Proximity, time: float, step: int) -> Proximity:
        """Return what the law acts on, and distance, pair and row of the closest pair as they are.

        Between two frames d and J_d, of every pair, stay those of the frame. The same step may be looked at several times.

        Args:
            actual: at the true posture; the world is at the posture that the joint sensors show.
            time: now [s].
            step: steps made before.
        """
        world, law, hardware = self._world, settings.law, settings.hardware
        if hardware.frame_rate > 0.0:
            frame = _frame(hardware, time)
            if frame != self._frame:
                self._frame, self._held = frame, world.positions.copy()
            world.kinematics.update(self._held)
            step = frame
        seen = world.detector.detect(law.pairs, law.beta, law.convexity)
        noise = hardware.distance_noise
        self.error = noise * float(normal(settings.seed, DISTANCE, step, 1)[0]) if noise > 0.0 else 0.0
        return Proximity(actual.distance, actual.pair, seen.law_distance + self.error, seen.row, actual.pair_row)

    def memory(self) -> Memory:
        """Return the posture of the last frame, and its number; no posture if there was none."""
        return self._held.copy(), np.array(self._frame)

    def remember(self, memory: Memory) -> None:
        """Go on with this frame."""
        self._held, self._frame = memory[0].copy(), int(memory[1])


def _frame(hardware: HardwareSettings, time: float) -> int:
    """Return the number of the newest frame; the slack is for times that are sums of many time steps."""
    return int(time * hardware.frame_rate + 1e-6)
