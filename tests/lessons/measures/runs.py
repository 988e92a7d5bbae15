"""Runs to measure, and what is seen of them without the measurements' own code."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pinocchio as pin

from app.lessons import FOLDER
from app.lessons.lesson import Start
from app.lessons.reference_runs import simulated
from app.lessons.room_places import RoomPlace
from app.lessons.runs import Input, Setup
from controllers.kinematics import Array
from scenes.history import COLUMN
from scenes.room import BALL_RADIUS, POINT_RADIUS
from scenes.simulation import Simulation

UP = (0.0, 0.0, 1.0)


def setup(seconds: float = 8.0, given: Input | None = None, start: Start | None = None, **changes: object) -> Setup:
    return Setup(tuple(changes.items()), given or Input("none"), start, seconds, FOLDER)


SOLO: dict[str, Any] = {"scene": "solo", "dt": 0.02}
BALL: dict[str, Any] = {"scene": "ball", "pairs": "single", "n": 2.0, "k": 2.0, "dt": 0.02}
TABLE: dict[str, Any] = {"rig": "table", "pairs": "single", "n": 2.0, "k": 2.0, "dt": 0.02}
TURN = Input("script", "elbow_to", (("angle", 0.6),))


def ball_at(*place: Any) -> Start:
    return Start(RoomPlace(*place))


RUNS: dict[str, Setup] = {
    "circle": setup(16.2, **SOLO, path="circle", k=0.5),
    "elbow": setup(8.0, TURN, **SOLO, k=2.0),
    "turned": setup(8.0, TURN, scene="solo", task="pose", k=5.0, dt=0.005),
    "pose": setup(1.0, **SOLO, task="pose"),
    "ball": setup(8.0, **BALL),
    "switch": setup(5.0, scene="ball", pairs="single", law="strict_switched", k=2.0, dt=0.005),
    "tail": setup(8.0, None, ball_at("goal", UP, 0.1), **BALL),
    "steep": setup(8.0, None, ball_at("goal", (0.0, -0.3145, -0.1), 0.2), **BALL | {"dm": 0.1, "n": 20.0, "k": 10.0}),
    "beside": setup(6.0, None, ball_at("elbow", UP, 0.14), **BALL | {"point": "elbow", "n": 6.0}),
    "short": setup(1.4, None, ball_at("elbow", "upper_arm", 0.1, 0.35), **BALL | {"point": "elbow", "dt": 0.01}),
    "push": setup(2.6, Input("script", "push", (("speed", 0.4),)), **TABLE | {"scene": "hold", "wmax": 0.4, "dt": 0.005}),
    "slave": setup(6.0, Input("autopilot"), scene="master_slave", **TABLE),
    "wave": setup(12.0, Input("autopilot"), scene="hold", rig="torso", pairs="single", dt=0.02),
}


@dataclass
class Seen:
    simulation: Simulation
    table: Array

    def col(self, name: str) -> Array:
        return self.table[:, COLUMN[name]]

    @property
    def q(self) -> Array:
        return self.simulation.history.positions(self.table)

    @property
    def dq(self) -> Array:
        return self.simulation.history.velocities(self.table)[:, self.simulation.avoiding.joints]

    def place(self, q: Array, what: str = "hand") -> Array:
        model, arm = self.simulation.room.model, self.simulation.avoiding
        data = model.createData()
        pin.framesForwardKinematics(model, data, np.ascontiguousarray(q))
        return (data.oMf[arm.hand].translation if what == "hand" else data.oMi[arm.elbow].translation).copy()

    def path(self, what: str) -> Array:
        return np.array([self.place(q, what) for q in self.q])

    def jacobian(self, function: Callable[[Array], Array], q: Array) -> Array:
        columns: list[Array] = []
        joints = self.simulation.avoiding.joints
        for j in range(joints.start, joints.stop):
            step = np.zeros_like(q)
            step[j] = 1e-6
            columns.append((function(q + step) - function(q - step)) / 2e-6)
        return np.array(columns, np.float64).T

    def point(self, q: Array) -> Array:
        return self.place(q, "hand" if self.simulation.settings.point == "hand" else "elbow")

    def gap(self, q: Array) -> Array:
        """Distance of the ball, by its radius and that of the control point (1,)."""
        ball = q[self.simulation.room.ball]
        return np.array([float(np.linalg.norm(self.point(q) - ball)) - BALL_RADIUS - POINT_RADIUS])

    def lever(self, row: int) -> Array:
        return self.jacobian(self.gap, self.q[row])[0]

    def hand_jacobian(self, row: int) -> Array:
        return self.jacobian(self.place, self.q[row])

    def blocks(self, row: int) -> Array:
        """M by eqs (17)–(25), with numpy's own pseudo-inverses and K_a = K_b = K."""
        lam, K = float(self.col("lambda")[row]), self.simulation.settings.gain
        J_a, J_b = self.lever(row)[None, :], self.hand_jacobian(row)
        a, b = np.linalg.pinv(J_a), np.linalg.pinv(J_b)
        N = np.eye(7) - lam * a @ J_a
        return K * np.block([[J_a @ a, J_a @ N @ b], [J_b @ a, J_b @ N @ b]])

    def least(self, row: int) -> float:
        M = self.blocks(row)
        return float(np.linalg.eigvalsh((M + M.T) / 2.0).min())

    def rho(self, row: int) -> float:
        j, J = self.lever(row), self.hand_jacobian(row)
        return float(np.linalg.norm(J.T @ np.linalg.lstsq(J.T, j, rcond=None)[0]) / np.linalg.norm(j))


@cache
def seen(name: str) -> Seen:
    simulation = simulated(RUNS[name])
    return Seen(simulation, simulation.history.table())


def looped_zigzag(d: Array) -> float:
    """Chatter, step by step."""
    steps, best = np.diff(d).tolist(), 0.0
    for k in range(len(steps) - 3):
        four = steps[k : k + 4]
        if all(a * b < 0.0 for a, b in pairwise(four)):
            best = max(best, min(map(abs, four)))
    return best
