"""The hold experiment in pink (Pinocchio and a QP): `FrameTask` and `SelfCollisionBarrier`.

Settings: the task's gain is the share of the error to be removed in one step, K dt; costs 1 per metre and per radian; the barrier's
gain is in 1/s; its safe displacement gain and the damping are pink's defaults. Joint stops are approached as ours are: at most g dt
of the way that is left in one step. The guided arm has no bounds, as its motion is given.

Note: the barrier's row changes its sign where two bodies overlap (`SelfCollisionBarrier.compute_jacobian` takes the normal
from the closest points), so that it would pull them together; no bodies overlap in this run. Rows are kept from the step before
when no joint has moved by more than about 1e-5 of its angle.
"""

from typing import Any, Final

import numpy as np
import pink
import pinocchio as pin
from pink.barriers import SelfCollisionBarrier
from pink.exceptions import NoSolutionFound
from pink.limits import ConfigurationLimit, VelocityLimit
from pink.tasks import FrameTask, Task

from app.bench.peer_hold import PEER_GAIN, Baked
from controllers.kinematics import Array

SOLVER: Final = "daqp"
UNBOUNDED: Final = 1e30
"""Of a joint without stops [rad]; pink takes more than 1e20 as none."""


class PinkGivenMotion(Task):
    """Joints with a given motion: Δq = q̇ dt, for the constraints of `pink.solve_ik`."""

    def __init__(self, columns: slice, nv: int) -> None:
        super().__init__(cost=None, gain=1.0)
        self._jacobian = np.eye(nv)[columns]
        self.displacement: Array = np.zeros(len(self._jacobian))

    def compute_error(self, configuration: Any) -> Array:
        """Return −Δq (n,), as pink solves J Δq = −gain · error."""
        return -self.displacement

    def compute_jacobian(self, configuration: Any) -> Array:
        """Return the rows of the identity that belong to the joints."""
        return self._jacobian

    def __repr__(self) -> str:
        return "GivenMotion()"


class PinkArm:
    """The avoiding arm moved by pink.

    Args:
        baked: the experiment.
        pairs: how many of the closest pairs the barrier sees.
    """

    def __init__(self, baked: Baked, pairs: int) -> None:
        settings, room = baked.settings, baked.room
        model = free_model(baked)
        self._baked, self._dt = baked, settings.dt
        self._configuration = pink.Configuration(model, model.createData(), room.start, collision_model=room.geometry)
        self._task = FrameTask(
            model.frames[baked.hand].name, position_cost=1.0, orientation_cost=1.0, gain=settings.gain * settings.dt
        )
        self._task.set_target(pin.SE3(baked.place_rotation, baked.place))
        self._barrier = SelfCollisionBarrier(pairs, gain=PEER_GAIN, d_min=settings.law.critical_distance)
        self._motion = PinkGivenMotion(baked.guided, model.nv)
        self._limits = [
            ConfigurationLimit(model, config_limit_gain=settings.limit_gain * settings.dt),
            VelocityLimit(model),
        ]
        self.positions = room.start.copy()
        self.unsolved = 0
        """Steps without a solution; the arm stands still in them."""

    def prepare(self, step: int) -> None:
        """Take over where the obstacle is and how it moves."""
        baked = self._baked
        self.positions[baked.guided] = baked.guided_positions[step]
        self._motion.displacement = baked.guided_velocities[step] * self._dt

    def advance(self, step: int) -> Array:
        """Make one step."""
        configuration = self._configuration
        configuration.update(self.positions)
        try:
            velocities = pink.solve_ik(
                configuration,
                [self._task],
                self._dt,
                SOLVER,
                limits=self._limits,
                barriers=[self._barrier],
                constraints=[self._motion],
            )
        except NoSolutionFound:
            self.unsolved += 1
            velocities = np.zeros(len(self.positions))
            velocities[self._baked.guided] = self._baked.guided_velocities[step]
        self.positions = configuration.integrate(velocities, self._dt)
        return velocities


def free_model(baked: Baked) -> pin.Model:
    """Return a copy of the model in which the guided arm has no bounds."""
    model = baked.room.model.copy()
    lower, upper, speed = model.lowerPositionLimit.copy(), model.upperPositionLimit.copy(), model.velocityLimit.copy()
    lower[baked.guided], upper[baked.guided], speed[baked.guided] = -UNBOUNDED, UNBOUNDED, UNBOUNDED
    model.lowerPositionLimit, model.upperPositionLimit, model.velocityLimit = lower, upper, speed
    return model


class PinkEngine:
    """Distances as pink sees them."""

    def __init__(self, baked: Baked) -> None:
        model, self._geometry = free_model(baked), baked.room.geometry
        self._frame = model.frames[baked.hand].name
        self._configuration = pink.Configuration(model, model.createData(), baked.room.start, collision_model=self._geometry)

    def distances(self, positions: Array) -> dict[tuple[str, str], float]:
        """Return every pair's distance [m]."""
        self._configuration.update(positions)
        bodies, results = self._geometry.geometryObjects, self._configuration.collision_data.distanceResults
        return {
            (bodies[pair.first].name, bodies[pair.second].name): results[i].min_distance
            for i, pair in enumerate(self._geometry.collisionPairs)
        }

    def hand_pose(self, positions: Array) -> tuple[Array, Array]:
        """Return place and rotation of the avoiding hand."""
        self._configuration.update(positions)
        pose = self._configuration.get_transform_frame_to_world(self._frame)
        return pose.translation, pose.rotation
