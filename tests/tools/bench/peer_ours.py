"""The hold experiment with our own laws."""

from dataclasses import replace
from functools import partial
from typing import Any, Final

import numpy as np

from controllers.kinematics import Array
from scenes.arm_tasks.arm_task import ArmTask, Memory
from scenes.laws import BARRIER_LAW, DEFAULT_LAW
from scenes.settings import RunSettings
from scenes.simulation import Simulation
from scenes.targets import Target
from tests.tools.bench.peer_method import PEER_GAIN, Baked, Method, PairDistances


class BakedArm(ArmTask):
    """The guided arm with its recorded motion, for `Simulation`."""

    def __init__(self, baked: Baked) -> None:
        self.joints = baked.guided
        self._way = list(baked.guided_velocities)
        self._step = 0

    def begin(self) -> None:
        self._step = 0

    def nominal(self, target: Target | None, settings: RunSettings, time: float) -> Array:
        del target, settings, time
        self._step += 1
        return self._way[self._step - 1]

    def memory(self) -> Memory:
        return (np.array([self._step]),)

    def remember(self, memory: Memory) -> None:
        self._step = int(memory[0][0])


class Ours(Method):
    """Our own simulation.

    Args:
        person: also compute the guided arm as it follows the person; otherwise replay its motion.
        law: fields of the law that differ from the obstacle's run.
    """

    def __init__(self, baked: Baked, person: bool = False, **law: Any) -> None:
        settings = replace(baked.settings, law=replace(baked.settings.law, **law))
        self._simulation = simulation = Simulation(settings, baked.steps)
        self._source = simulation.source() if person else None
        if not person:
            obstacle = BakedArm(baked)
            simulation.roles = replace(
                simulation.roles, tasks=(obstacle, simulation.roles.task), held=obstacle
            )
            simulation.reset()
        self.positions = simulation.positions
        self._hand = baked.hand

    def advance(self, step: int) -> Array:
        del step
        self._simulation.step(None if self._source is None else self._source.target(self._simulation.time))
        self.positions = self._simulation.positions
        return self._simulation.velocities

    def distances(self, positions: Array) -> PairDistances:
        self.nearest(positions)
        detector = self._simulation.detector
        return dict(zip(detector.pair_names, detector.distances().tolist(), strict=True))

    def hand_pose(self, positions: Array) -> tuple[Array, Array]:
        self._simulation.kinematics.update(positions)
        pose = self._simulation.kinematics.data.oMf[self._hand]
        return pose.translation.copy(), pose.rotation.copy()

    def nearest(self, positions: Array) -> float:
        """Smallest distance at q (nv,) [m]."""
        self._simulation.kinematics.update(positions)
        return self._simulation.detector.detect().distance


METHODS: Final = {
    "ours, single pair (paper)": partial(Ours, law=DEFAULT_LAW, pairs="single"),
    "ours, soft minimum": partial(Ours, law=DEFAULT_LAW, pairs="soft"),
    "ours, smooth everywhere": partial(Ours, law=DEFAULT_LAW, pairs="smooth"),
    "the same and the person's arm": partial(Ours, person=True, law=DEFAULT_LAW, pairs="smooth"),
    "ours, barrier QP, all pairs +w": partial(
        Ours, law=BARRIER_LAW, pairs="single", feed_forward=True, barrier_gain=PEER_GAIN
    ),
}
