"""The hold experiment in pink (Pinocchio and a QP): `FrameTask` and `SelfCollisionBarrier`.

Settings: task gain K dt, costs 1 per metre and per radian, the barrier's gain in 1/s, pink's default damping
and safe displacement gain, joint stops as ours. The barrier's row changes its sign at an overlap, which does
not occur in this run; rows are kept from the previous step if no joint moved by more than about 1e-5 of its
angle.
"""

from functools import partial
from typing import Final

import pink
import pinocchio as pin
from pink.barriers import SelfCollisionBarrier
from pink.exceptions import NoSolutionFound
from pink.limits import ConfigurationLimit, VelocityLimit
from pink.tasks import FrameTask, Task

from controllers.kinematics import Array
from tests.tools.bench.peer_method import PEER_GAIN, SOLVER, Baked, GivenMotion, PairDistances, Peer

UNBOUNDED: Final = 1e30
"""Stop of a joint without stops [rad]; for pink, over 1e20 means no stop."""


class PinkGivenMotion(GivenMotion, Task):
    """The guided arm's motion for pink."""

    __repr__ = object.__repr__


class Pink(Peer):
    """The avoiding arm moved by pink. `pairs`: number of closest pairs in the barrier; None for all."""

    unsolvable = NoSolutionFound

    def __init__(self, baked: Baked, pairs: int | None = None) -> None:
        super().__init__(baked)
        settings, model, self._geometry = baked.settings, baked.room.model.copy(), baked.room.geometry
        lower, upper, speed = (
            model.lowerPositionLimit.copy(),
            model.upperPositionLimit.copy(),
            model.velocityLimit.copy(),
        )
        lower[baked.guided], upper[baked.guided], speed[baked.guided] = -UNBOUNDED, UNBOUNDED, UNBOUNDED
        model.lowerPositionLimit, model.upperPositionLimit, model.velocityLimit = lower, upper, speed
        self._configuration = pink.Configuration(
            model, model.createData(), baked.room.start, collision_model=self._geometry
        )
        self._motion = PinkGivenMotion(baked.guided, model.nv, cost=None, gain=1.0)
        self._hand = model.frames[baked.hand].name
        self._task = FrameTask(
            self._hand, position_cost=1.0, orientation_cost=1.0, gain=settings.gain * settings.dt
        )
        self._task.set_target(pin.SE3(baked.place_rotation, baked.place))
        count = len(self._geometry.collisionPairs) if pairs is None else pairs
        self._barrier = SelfCollisionBarrier(count, gain=PEER_GAIN, d_min=settings.law.critical_distance)
        self._limits = [
            ConfigurationLimit(model, config_limit_gain=settings.limit_gain * settings.dt),
            VelocityLimit(model),
        ]

    def solve(self, step: int) -> Array:
        self._configuration.update(self.positions)
        self._motion.take(self.baked, step)
        posture, tasks, dt, given = self._configuration, [self._task], self.baked.settings.dt, [self._motion]
        return pink.solve_ik(
            posture, tasks, dt, SOLVER, limits=self._limits, barriers=[self._barrier], constraints=given
        )

    def distances(self, positions: Array) -> PairDistances:
        self._configuration.update(positions)
        results = self._configuration.collision_data.distanceResults
        return {pair: result.min_distance for pair, result in zip(self.baked.pairs, results, strict=True)}

    def hand_pose(self, positions: Array) -> tuple[Array, Array]:
        self._configuration.update(positions)
        pose = self._configuration.get_transform_frame_to_world(self._hand)
        return pose.translation, pose.rotation


METHODS: Final = {"pink, all pairs +w": Pink, "pink, 3 closest pairs +w": partial(Pink, pairs=3)}
