"""The hold experiment in embodik (Pinocchio, coal and its own solver, all in C++): `FrameTask` and its
collision constraint.

Settings: task weight K, which is its gain [1/s] there; the least error instead of the scaled task, which
oscillates at every second step; only the avoiding arm's joints serve the task; full exact collision checks,
one row per pair; otherwise embodik's defaults. Its collision constraint has no gain. w can be given in two
ways: the guided joints' velocities as a task of higher priority, or as equality rows. Without w these joints
have speed 0 for the solver.
"""

import tempfile
from functools import partial
from pathlib import Path
from typing import Final, Literal

import embodik
import numpy as np
from numpy.typing import NDArray

from controllers.kinematics import Array
from tests.tools.bench.peer_method import HAND, Baked, PairDistances, Peer, urdf_text


class NotSolved(Exception):
    """embodik's solver found no solution."""


class Embodik(Peer):
    """The avoiding arm moved by embodik.

    Args:
        pairs: number of closest pairs with a row; None for all.
        speed: form of the guided arm's velocity: task of higher priority or equality rows; None: not given.
    """

    unsolvable = NotSolved

    def __init__(
        self, baked: Baked, pairs: int | None = None, speed: Literal["task", "rows"] | None = None
    ) -> None:
        super().__init__(baked)
        settings, self._speed = baked.settings, speed
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "duet.urdf"
            path.write_text(urdf_text(baked), encoding="utf-8")
            self._robot = robot = embodik.RobotModel(str(path))
        names = list(baked.room.model.names)[1:]
        self._columns: NDArray[np.intp] = np.array(
            [robot.get_joint_config_index(name) for name in names], dtype=np.intp
        )
        guided = self._columns[baked.guided]
        known = {name.rpartition("_")[0]: name for name in robot.get_collision_geometry_names()}
        named = [(known[first], known[second]) for first, second in baked.pairs]
        self._ours = {frozenset(pair): ours for pair, ours in zip(named, baked.pairs, strict=True)}
        self._solver = solver = embodik.KinematicsSolver(robot)
        solver.dt = settings.dt
        solver.set_collision_tuning_mode(embodik.CollisionTuningMode.PRECISE)
        rows = len(named) if pairs is None else pairs
        solver.configure_collision_constraint(
            settings.law.critical_distance, include_pairs=named, max_constraints=rows
        )
        solver.enable_position_limits(True)
        solver.enable_velocity_limits(True)
        hand = solver.add_frame_task(HAND, HAND)
        hand.set_target_pose(baked.place, np.asfortranarray(baked.place_rotation))
        hand.weight, hand.solve_mode, hand.priority = settings.gain, embodik.TaskSolveMode.MIN_ERROR, 1
        if speed != "rows":
            # Otherwise its solver finds no solution with the other joints' equality rows.
            hand.set_excluded_joint_indices(guided.tolist())
        self._rows = np.asfortranarray(np.eye(robot.nv)[guided])
        if speed == "task":
            self._guided = solver.add_posture_task("guided", guided.tolist())
            self._guided.priority, self._guided.solve_mode = 0, embodik.TaskSolveMode.MIN_ERROR
        elif speed is None:
            for column in guided.tolist():
                solver.set_joint_velocity_limit(column, 0.0)
        self._q = np.zeros(robot.nq)

    def solve(self, step: int) -> Array:
        self._q[self._columns] = self.positions
        motion = self.baked.guided_velocities[step]
        if self._speed == "task":
            self._guided.set_target_velocity(motion)
        elif self._speed == "rows":
            self._solver.set_linear_velocity_constraints(self._rows, motion, motion)
        answer = self._solver.solve_velocity(self._q)
        if answer.status != embodik.SolverStatus.SUCCESS:
            raise NotSolved
        return np.asarray(answer.joint_velocities)[self._columns]

    def distances(self, positions: Array) -> PairDistances:
        self._take(positions)
        names, found = self._robot.get_collision_pair_names(), self._robot.compute_collision_distances()
        keyed = zip(map(frozenset, names), found, strict=True)
        return {self._ours[key]: distance for key, distance in keyed if key in self._ours}

    def hand_pose(self, positions: Array) -> tuple[Array, Array]:
        self._take(positions)
        pose = self._robot.get_frame_pose(HAND)
        return np.array(pose.translation), np.array(pose.rotation)

    def _take(self, positions: Array) -> None:
        self._q[self._columns] = positions
        self._robot.update_configuration(self._q)


METHODS: Final = {
    "embodik, all pairs +w": partial(Embodik, speed="task"),
    "embodik, all pairs +w as rows": partial(Embodik, speed="rows"),
    "embodik, all pairs": Embodik,
    "embodik, 3 closest pairs": partial(Embodik, pairs=3),
}
