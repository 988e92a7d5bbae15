"""The way from a commanded joint velocity to the one that the joints have: dead time, then a first-order lag."""

import math
from bisect import bisect_right
from typing import Final

import numpy as np

from controllers.kinematics import Array
from scenes.arm_tasks.arm_task import Memory
from scenes.settings import HardwareSettings, specs

LONGEST: Final = specs(HardwareSettings)["dead"].high
"""Longest dead time [s]; commands are kept for as long, so that a change of the dead time finds what was commanded then."""

SLACK: Final = 1e-9
"""Of a comparison of times, which are sums of many time steps [s]."""


class Actuation:
    """The commands on their way. `joints`: how many values a command has."""

    def __init__(self, joints: int) -> None:
        self._joints = joints
        self._times: list[float] = []
        self._commands: list[Array] = []

    def clear(self) -> None:
        """Forget all commands."""
        self._times.clear()
        self._commands.clear()

    def reached(self, hardware: HardwareSettings, command: Array, before: Array, time: float, dt: float) -> Array:
        """Return q̇ (nv,) during the step that begins now; call it once a step [rad/s].

        A command acts in the first step that begins the dead time after its own or later. Until the first one arrives the joints
        keep their velocity. The lag is exact for a command that is constant during a step.

        Args:
            command: q̇ (nv,) that is asked for now [rad/s].
            before: q̇ (nv,) of the step before [rad/s].
            time: now [s].
        """
        if hardware.dead_time > 0.0:
            self._times.append(time)
            self._commands.append(command.copy())
            while len(self._times) > 1 and self._times[1] <= time - LONGEST + SLACK:
                del self._times[0], self._commands[0]
            newest = bisect_right(self._times, time - hardware.dead_time + SLACK) - 1
            command = self._commands[newest] if newest >= 0 else before
        if hardware.lag > 0.0:
            return before - math.expm1(-dt / hardware.lag) * (command - before)
        return command

    def memory(self) -> Memory:
        """Return the times (k,) and the commands (k, nv) that are kept."""
        return np.array(self._times), np.array(self._commands).reshape(-1, self._joints)

    def remember(self, memory: Memory) -> None:
        """Go on with these commands."""
        times, commands = memory
        self._times, self._commands = times.tolist(), [command.copy() for command in commands]


def before_stops(velocities: Array, positions: Array, lower: Array, upper: Array, dt: float) -> Array:
    """Return q̇ (n,) of joints that their mechanical stops hold back: a lagging joint may run into one [rad/s].

    Args:
        velocities: q̇ (n,) without stops [rad/s].
        positions, lower, upper: q and the stops (n,) [rad].
    """
    return np.clip(velocities, np.minimum((lower - positions) / dt, 0.0), np.maximum((upper - positions) / dt, 0.0))
