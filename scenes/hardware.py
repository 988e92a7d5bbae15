"""A real arm: sensors with noise, resolution and frames; commands with dead time and lag.

Noise depends only on seed and step (or frame), so a run can be resumed anywhere.
"""

import math
from bisect import bisect_right
from typing import Final

import numpy as np
from numpy.typing import NDArray

from controllers.kinematics import Arm, Array
from controllers.proximity import Proximity
from scenes.arm_tasks.arm_task import Memory
from scenes.room import World
from scenes.settings import HardwareSettings, RunSettings, specs

JOINTS, DISTANCE = 0, 1


def normal(seed: int, stream: int, index: int, count: int) -> Array:
    """Reproducible standard normal numbers (count,); index ≥ 0."""
    return np.random.Generator(np.random.Philox(key=seed, counter=[0, index, stream, 0])).standard_normal(
        count
    )


def measured_positions(settings: RunSettings, positions: Array, arms: tuple[Arm, ...], step: int) -> Array:
    """q (nv,) by the joint sensors [rad]; entries of other things are exact.

    Args:
        positions: true q (nv,) [rad].
        step: steps made.
    """
    hardware, seen = settings.hardware, positions.copy()
    noise = (
        normal(settings.seed, JOINTS, step, len(seen)) * hardware.joint_noise
        if hardware.joint_noise > 0.0
        else None
    )
    for arm in arms:
        if noise is not None:
            seen[arm.joints] += noise[arm.joints]
        if hardware.joint_resolution > 0.0:
            seen[arm.joints] = (
                np.round(seen[arm.joints] / hardware.joint_resolution) * hardware.joint_resolution
            )
    return seen


class Sensing:
    """Distance sensor at the measured posture. `error`: of the newest distance [m]."""

    def __init__(self, world: World) -> None:
        self._world = world
        self.clear()

    def clear(self) -> None:
        self.error = 0.0
        self._frame = -1
        self._held = np.empty(0)

    def proximity(self, settings: RunSettings, actual: Proximity, time: float, step: int) -> Proximity:
        """Input of the law, with the true distance, pair and row of the closest pair.

        Between frames d and J_d of every pair keep their values. A step may be measured several times.

        Args:
            actual: at the true posture; the world is at the measured one.
            time: now [s].
            step: steps made.
        """
        world, law, hardware = self._world, settings.law, settings.hardware
        if hardware.frame_rate > 0.0:
            # The slack is for times that are sums of many time steps.
            frame = int(time * hardware.frame_rate + 1e-6)
            if frame != self._frame:
                self._frame, self._held = frame, world.positions.copy()
            world.kinematics.update(self._held)
            step = frame
        seen = world.detector.detect(*law.proximity)
        noise = hardware.distance_noise
        self.error = noise * float(normal(settings.seed, DISTANCE, step, 1)[0]) if noise > 0.0 else 0.0
        return Proximity(
            actual.distance, actual.pair, seen.law_distance + self.error, seen.row, actual.pair_row
        )

    def memory(self) -> Memory:
        """Posture of the last frame, (0,) before the first, and its number."""
        return self._held.copy(), np.array(self._frame)

    def remember(self, memory: Memory) -> None:
        self._held, self._frame = memory[0].copy(), int(memory[1])


LONGEST: Final = specs(HardwareSettings)["dead"].high
"""[s]; commands are kept for this time, as the dead time may change."""

SLACK: Final = 1e-9
"""[s]; times are sums of many time steps."""


class Actuation:
    """Commands in transit. `joints`: nv."""

    def __init__(self, joints: int) -> None:
        self._joints = joints
        self.clear()

    def clear(self) -> None:
        self._times: list[float] = []
        self._commands: list[Array] = []
        self._end = np.empty(0)

    def reached(
        self, hardware: HardwareSettings, command: Array, before: Array, time: float, dt: float
    ) -> Array:
        """Mean q̇ (nv,) of the step that begins now [rad/s]; call it once per step.

        A command acts in the first step that begins at least the dead time later. Before the first command
        arrives, the joints keep their velocity. A lag is τ q̈ = q̇_cmd − q̇, exact for a constant command.

        Args:
            command: present q̇_cmd (nv,) [rad/s].
            before: mean q̇ (nv,) of the last step [rad/s].
            time: now [s].
        """
        if hardware.dead_time > 0.0:
            self._times.append(time)
            self._commands.append(command.copy())
            while len(self._times) > 1 and self._times[1] <= time - LONGEST + SLACK:
                del self._times[0], self._commands[0]
            newest = bisect_right(self._times, time - hardware.dead_time + SLACK) - 1
            command = self._commands[newest] if newest >= 0 else before
        else:
            self._times.clear()
            self._commands.clear()
        lag = hardware.lag
        if lag == 0.0:
            self._end = np.empty(0)
            return command
        behind = (self._end if len(self._end) else before) - command
        self._end = command + math.exp(-dt / lag) * behind
        return command - (lag / dt) * math.expm1(-dt / lag) * behind

    def stop(self, joints: NDArray[np.bool_]) -> None:
        """Stop `joints` (nv,), which met their stops."""
        if len(self._end):
            self._end[joints] = 0.0

    def memory(self) -> Memory:
        """Times (k,) and commands (k, nv), and q̇ (nv,) at the step's end, (0,) without a lag."""
        return np.array(self._times), np.array(self._commands).reshape(-1, self._joints), self._end.copy()

    def remember(self, memory: Memory) -> None:
        times, commands, end = memory
        self._end = end.copy()
        self._times, self._commands = times.tolist(), [command.copy() for command in commands]


def before_stops(velocities: Array, positions: Array, lower: Array, upper: Array, dt: float) -> Array:
    """q̇ (n,) limited by the stops [rad/s]; lag or a sensor error may lead to them.

    Args:
        velocities: (n,) [rad/s].
        positions, lower, upper: q and the stops (n,) [rad].
    """
    return np.clip(
        velocities, np.minimum((lower - positions) / dt, 0.0), np.maximum((upper - positions) / dt, 0.0)
    )
