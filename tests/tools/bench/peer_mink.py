"""The hold experiment in mink (MuJoCo and a QP): `FrameTask` and `CollisionAvoidanceLimit`, on our model in
MuJoCo.

Settings: task gain K dt, costs 1 per metre and per radian, damping 1e-3 as in mink's examples, pairs from 2
d_m on, joint stops as ours. `CollisionAvoidanceLimit` bounds the displacement of a step by gain · (d − d_m) /
dt, so its documented range of gains, (0, 1], allows bodies closer than d_m within one step; `matched_gain`
means 10/s. Below d_m it wants no retreat.
"""

from functools import partial
from typing import Final

import mink
import mujoco
import numpy as np
from mink.exceptions import NoSolutionFound

from controllers.kinematics import Array
from tests.tools.bench.peer_method import (
    HAND,
    PEER_GAIN,
    SOLVER,
    Baked,
    GivenMotion,
    PairDistances,
    Peer,
    urdf_text,
)

FAR: Final = 100.0
"""Larger than any distance [m]."""


def matched_gain(dt: float) -> float:
    """Gain of mink's collision limit that equals `PEER_GAIN` [1/s]."""
    return PEER_GAIN * dt * dt


def mujoco_model(baked: Baked) -> mujoco.MjModel:
    """Our model in MuJoCo: the same joints, capsules and names, the avoiding hand as body "hand"."""
    spec = mujoco.MjSpec.from_string(urdf_text(baked))
    # MuJoCo needs masses, which have no effect here.
    spec.compiler.boundmass = spec.compiler.boundinertia = 1.0
    spec.compiler.fusestatic = False
    for geom in spec.geoms:
        geom.type = mujoco.mjtGeom.mjGEOM_CAPSULE
    for joint in spec.joints[baked.guided]:
        joint.limited = False
    return spec.compile()


class MinkGivenMotion(GivenMotion, mink.Task):
    """The guided arm's motion for mink."""


class Mink(Peer):
    """The avoiding arm moved by mink. `gain`: of `CollisionAvoidanceLimit`; None: equal to `PEER_GAIN`."""

    unsolvable = NoSolutionFound

    def __init__(self, baked: Baked, gain: float | None = None) -> None:
        super().__init__(baked)
        settings, self._model = baked.settings, mujoco_model(baked)
        self.configuration = mink.Configuration(self._model, baked.room.start)
        self._motion = MinkGivenMotion(
            baked.guided, self._model.nv, cost=np.ones(baked.guided.stop - baked.guided.start)
        )
        self._task = mink.FrameTask(
            HAND, "body", position_cost=1.0, orientation_cost=1.0, gain=settings.gain * settings.dt
        )
        self._task.set_target_from_configuration(self.configuration)
        avoiding = range(baked.avoiding.start, baked.avoiding.stop)
        self.limit = mink.CollisionAvoidanceLimit(
            self._model,
            [([first], [second]) for first, second in baked.pairs],
            gain=matched_gain(settings.dt) if gain is None else gain,
            minimum_distance_from_collisions=settings.law.critical_distance,
            collision_detection_distance=2.0 * settings.law.critical_distance,
        )
        self._limits = [
            mink.ConfigurationLimit(self._model, gain=settings.limit_gain * settings.dt),
            mink.VelocityLimit(
                self._model, {self._model.joint(i).name: baked.room.model.velocityLimit[i] for i in avoiding}
            ),
            self.limit,
        ]

    def solve(self, step: int) -> Array:
        self.configuration.update(self.positions)
        self._motion.take(self.baked, step)
        posture, tasks, dt, given = self.configuration, [self._task], self.baked.settings.dt, [self._motion]
        return mink.solve_ik(posture, tasks, dt, SOLVER, damping=1e-3, limits=self._limits, constraints=given)

    def distances(self, positions: Array) -> PairDistances:
        """Distances of the pairs that mink keeps."""
        self.configuration.update(positions)
        ours, ends = {frozenset(pair): pair for pair in self.baked.pairs}, np.empty(6)
        return {
            ours[frozenset(self._model.geom(i).name for i in pair)]: mujoco.mj_geomDistance(
                self._model, self.configuration.data, *pair, FAR, ends
            )
            for pair in self.limit.geom_id_pairs
        }

    def hand_pose(self, positions: Array) -> tuple[Array, Array]:
        self.configuration.update(positions)
        body = self.configuration.data.body(HAND)
        return body.xpos.copy(), body.xmat.reshape(3, 3).copy()


METHODS: Final = {"mink, all pairs +w": Mink, "mink, all pairs, default gain +w": partial(Mink, gain=0.85)}
