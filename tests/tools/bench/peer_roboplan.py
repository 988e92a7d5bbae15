"""The hold experiment in roboplan (Pinocchio, coal and ProxQP, all in C++): `FrameTask` and its
self-collision barrier.

Settings: K and the barrier's gain as for the other peers, no pull towards a safe displacement, no culled
pair; otherwise roboplan's defaults. w is given as a task of higher priority for the guided joints; without it
these joints have speed 0 for the solver. roboplan gives no distances, only whether any two capsules overlap.
"""

from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray
from roboplan import core, optimal_ik

from controllers.kinematics import Array
from tests.tools.bench.peer_method import HAND, PEER_GAIN, Baked, Peer, urdf_text

STILL: Final = 1e-9
"""Practically no speed [rad/s]; 0 is refused."""


class RoboPlan(Peer):
    """The avoiding arm moved by roboplan.

    Args:
        pairs: number of closest pairs with a row; None for all.
        knows_speed: give the solver the guided arm's velocity.
    """

    unsolvable = RuntimeError

    def __init__(self, baked: Baked, pairs: int | None = None, knows_speed: bool = True) -> None:
        super().__init__(baked)
        settings, model = baked.settings, baked.room.model
        # It needs unique frame names, and Pinocchio's root is "universe".
        self._scene = scene = core.Scene(
            "duet", core.loadUrdfSceneDescriptionFromXml(urdf_text(baked, "ground"))
        )
        names = [capsule.name for capsule in baked.room.geometry.geometryObjects]
        scene.setCollisions(
            [(first, second) for i, first in enumerate(names) for second in names[i + 1 :]], False
        )
        scene.setCollisions(list(baked.pairs), True)
        self._columns: NDArray[np.int32] = scene.getJointPositionIndices(list(model.names)[1:])
        self._guided = self._columns[baked.guided]
        self._solver = solver = optimal_ik.Oink(scene)
        place = core.CartesianConfiguration()
        place.tip_frame, pose = HAND, np.eye(4)
        pose[:3, :3], pose[:3, 3] = baked.place_rotation, baked.place
        place.tform = pose
        options = optimal_ik.FrameTaskOptions(task_gain=settings.gain * settings.dt, priority=2)
        self._tasks: list[optimal_ik.Task] = [optimal_ik.FrameTask(solver, scene, place, options)]
        speeds, weights = np.empty(model.nv), np.zeros(model.nv)
        speeds[self._columns], weights[self._guided] = model.velocityLimit, 1.0
        speeds[self._guided] = np.inf if knows_speed else STILL
        self._motion = None
        if knows_speed:
            first = optimal_ik.ConfigurationTaskOptions(task_gain=1.0, priority=1)
            self._motion = optimal_ik.ConfigurationTask(solver, np.zeros(model.nv), weights, first)
            self._tasks.insert(0, self._motion)
        self._limits = [
            optimal_ik.VelocityLimit(solver, settings.dt, speeds),
            optimal_ik.PositionLimit(solver),
        ]
        rows = optimal_ik.SelfCollisionBarrierOptions(
            n_collision_pairs=len(baked.pairs) if pairs is None else pairs,
            gain=PEER_GAIN,
            safe_displacement_gain=0.0,
            d_min=settings.law.critical_distance,
            d_max=None,
        )
        self._barriers = [optimal_ik.SelfCollisionBarrier(solver, scene, settings.dt, rows)]
        self._q, self._change = np.zeros(model.nq), np.zeros(model.nv)

    def solve(self, step: int) -> Array:
        self._q[self._columns] = self.positions
        if self._motion is not None:
            wanted = self._q.copy()
            wanted[self._guided] += self.baked.guided_velocities[step] * self.baked.settings.dt
            self._motion.setTargetConfiguration(wanted)
        self._solver.solveIk(self._q, self._tasks, self._limits, self._barriers, self._change)
        return self._change[self._columns] / self.baked.settings.dt

    def distances(self, positions: Array) -> bool:
        self._q[self._columns] = positions
        return self._scene.hasCollisions(self._q)

    def hand_pose(self, positions: Array) -> tuple[Array, Array]:
        self._q[self._columns] = positions
        pose = self._scene.forwardKinematics(self._q, HAND)
        return pose[:3, 3].copy(), pose[:3, :3].copy()


METHODS: Final = {
    "roboplan, all pairs +w": RoboPlan,
    "roboplan, 3 closest pairs +w": partial(RoboPlan, pairs=3),
    "roboplan, all pairs": partial(RoboPlan, knows_speed=False),
}
