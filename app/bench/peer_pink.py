"""The hold experiment in pink (Pinocchio and a QP): `FrameTask` and `SelfCollisionBarrier`.

Settings: gain K dt of the task, costs 1 per metre and per radian, the barrier's gain in 1/s, its safe displacement gain and the damping
pink's defaults, joint stops as ours. The barrier's row changes its sign where two bodies overlap, which none do in this run; rows are kept
from the step before when no joint has moved by more than about 1e-5 of its angle.
"""

from typing import Final

import pink
import pinocchio as pin
from pink.barriers import SelfCollisionBarrier
from pink.exceptions import NoSolutionFound
from pink.limits import ConfigurationLimit, VelocityLimit
from pink.tasks import FrameTask, Task

from app.bench.peer_hold import PEER_GAIN, Baked, GivenMotion, PeerArm
from controllers.kinematics import Array

SOLVER: Final = "daqp"
UNBOUNDED: Final = 1e30
"""Of a joint without stops [rad]; pink takes more than 1e20 as none."""


class PinkGivenMotion(GivenMotion, Task):
    """The guided arm's motion for pink."""

    __repr__ = object.__repr__


class PinkArm(PeerArm):
    """The avoiding arm moved by pink. `pairs`: how many of the closest pairs the barrier sees."""

    def __init__(self, baked: Baked, pairs: int) -> None:
        settings, room = baked.settings, baked.room
        model = free_model(baked)
        configuration = pink.Configuration(model, model.createData(), room.start, collision_model=room.geometry)
        motion = PinkGivenMotion(baked.guided, model.nv, cost=None, gain=1.0)
        super().__init__(baked, configuration, motion, NoSolutionFound)
        self._task = FrameTask(
            model.frames[baked.hand].name, position_cost=1.0, orientation_cost=1.0, gain=settings.gain * settings.dt
        )
        self._task.set_target(pin.SE3(baked.place_rotation, baked.place))
        self._barrier = SelfCollisionBarrier(pairs, gain=PEER_GAIN, d_min=settings.law.critical_distance)
        self._limits = [
            ConfigurationLimit(model, config_limit_gain=settings.limit_gain * settings.dt),
            VelocityLimit(model),
        ]

    def solve(self) -> Array:
        posture, tasks, given = self._configuration, [self._task], self.constraints
        return pink.solve_ik(posture, tasks, self._dt, SOLVER, limits=self._limits, barriers=[self._barrier], constraints=given)


def free_model(baked: Baked) -> pin.Model:
    """Return a copy of the model in which the guided arm has no bounds."""
    model = baked.room.model.copy()
    lower, upper, speed = model.lowerPositionLimit.copy(), model.upperPositionLimit.copy(), model.velocityLimit.copy()
    lower[baked.guided], upper[baked.guided], speed[baked.guided] = -UNBOUNDED, UNBOUNDED, UNBOUNDED
    model.lowerPositionLimit, model.upperPositionLimit, model.velocityLimit = lower, upper, speed
    return model


class PinkEngine:
    """An `Engine`: distances as pink sees them."""

    def __init__(self, baked: Baked) -> None:
        model, self._geometry = free_model(baked), baked.room.geometry
        self._frame = model.frames[baked.hand].name
        self._configuration = pink.Configuration(model, model.createData(), baked.room.start, collision_model=self._geometry)

    def distances(self, positions: Array) -> dict[tuple[str, str], float]:
        self._configuration.update(positions)
        bodies, results = self._geometry.geometryObjects, self._configuration.collision_data.distanceResults
        return {
            (bodies[pair.first].name, bodies[pair.second].name): results[i].min_distance
            for i, pair in enumerate(self._geometry.collisionPairs)
        }

    def hand_pose(self, positions: Array) -> tuple[Array, Array]:
        self._configuration.update(positions)
        pose = self._configuration.get_transform_frame_to_world(self._frame)
        return pose.translation, pose.rotation
