"""Every measurement against an independent computation, which shares only the run with it, not the code."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.distance import pdist

from app.features.lessons.folder import FOLDER
from app.features.lessons.lesson import Start
from app.features.lessons.reference_runs import simulated
from app.features.lessons.runs import Input, Setup, settings_text
from app.features.measures.evidence import Evidence
from app.features.measures.quantities.quantity import QUANTITIES, measure, shown_value
from app.features.measures.room_places import RoomPlace
from controllers.kinematics import Array
from scenes.ball import BALL_RADIUS, PATH, POINT_RADIUS
from scenes.history import COLUMN
from scenes.simulation import Simulation
from tests.approved import Approve
from tests.controllers.helpers import derivative

UP = (0.0, 0.0, 1.0)


def setup(
    seconds: float = 8.0, given: Input | None = None, start: Start | None = None, **changes: object
) -> Setup:
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
    "steep": setup(
        8.0, None, ball_at("goal", (0.0, -0.3145, -0.1), 0.2), **BALL | {"dm": 0.1, "n": 20.0, "k": 10.0}
    ),
    "beside": setup(6.0, None, ball_at("elbow", UP, 0.14), **BALL | {"point": "elbow", "n": 6.0}),
    "short": setup(
        1.4, None, ball_at("elbow", "upper_arm", 0.1, 0.35), **BALL | {"point": "elbow", "dt": 0.01}
    ),
    "straight": setup(
        1.4, None, ball_at("elbow", "upper_arm", 0.1, 0.02), **BALL | {"point": "elbow", "dt": 0.01}
    ),
    "push": setup(
        2.6, Input("script", "push", (("speed", 0.4),)), **TABLE | {"scene": "hold", "wmax": 0.4, "dt": 0.005}
    ),
    "slave": setup(6.0, Input("autopilot"), scene="master_slave", **TABLE),
    "stops": setup(
        3.0,
        Input("script", "hand_to", (("z", -0.35), ("speed", 0.2))),
        scene="first_task",
        first="stops",
        dm=0.1,
        dt=0.02,
    ),
    "reach": setup(
        4.0,
        Input("script", "hand_to", (("x", 0.8), ("speed", 0.2))),
        scene="first_task",
        first="singular",
        dm=0.1,
        dt=0.02,
    ),
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

    def turn(self, row: int) -> Array:
        model, data = self.simulation.room.model, self.simulation.room.model.createData()
        pin.framesForwardKinematics(model, data, np.ascontiguousarray(self.q[row]))
        return data.oMf[self.simulation.avoiding.hand].rotation.copy()

    def path(self, what: str) -> Array:
        return np.array([self.place(q, what) for q in self.q])

    def jacobian(self, function: Callable[[Array], Array], q: Array) -> Array:
        return derivative(function, q)[:, self.simulation.avoiding.joints]

    def gap(self, q: Array) -> Array:
        """Distance of the ball's surface from the control point's sphere (1,)."""
        point = self.place(q, "hand" if self.simulation.settings.point == "hand" else "elbow")
        return np.array(
            [float(np.linalg.norm(point - q[self.simulation.room.ball])) - BALL_RADIUS - POINT_RADIUS]
        )

    def lever(self, row: int) -> Array:
        return self.jacobian(self.gap, self.q[row])[0]

    def hand_jacobian(self, row: int) -> Array:
        return self.jacobian(self.place, self.q[row])

    def least(self, row: int) -> float:
        """Smallest eigenvalue of sym(M) of eqs (17)–(25), by numpy's pseudo-inverses, K_a = K_b = K."""
        lam, K = float(self.col("lambda")[row]), self.simulation.settings.gain
        J_a, J_b = self.lever(row)[None, :], self.hand_jacobian(row)
        a, b = np.linalg.pinv(J_a), np.linalg.pinv(J_b)
        N = np.eye(7) - lam * a @ J_a
        M = K * np.block([[J_a @ a, J_a @ N @ b], [J_b @ a, J_b @ N @ b]])
        return float(np.linalg.eigvalsh((M + M.T) / 2.0).min())

    def to_stops(self, row: int) -> float:
        model, j = self.simulation.room.model, self.simulation.avoiding.joints
        low, high = model.lowerPositionLimit[j], model.upperPositionLimit[j]
        return min(min(q - a, b - q) for q, a, b in zip(self.q[row, j], low, high, strict=True))

    def least_singular(self, row: int) -> float:
        J = self.hand_jacobian(row)
        return float(np.sqrt(max(np.linalg.eigvalsh(J @ J.T).min(), 0.0)))

    def rho(self, row: int) -> float:
        j, J = self.lever(row), self.hand_jacobian(row)
        return float(np.linalg.norm(J.T @ np.linalg.lstsq(J.T, j, rcond=None)[0]) / np.linalg.norm(j))


@cache
def seen(name: str) -> Seen:
    simulation = simulated(RUNS[name])
    return Seen(simulation, simulation.history.table())


def looped_zigzag(d: Array) -> float:
    """Chatter, computed with a plain loop."""
    steps, best = np.diff(d).tolist(), 0.0
    for k in range(len(steps) - 3):
        four = steps[k : k + 4]
        if all(a * b < 0.0 for a, b in pairwise(four)):
            best = max(best, min(map(abs, four)))
    return best


def circle_error(s: Seen, time: float) -> Array:
    """Error e of the hand on its circle (radius 0.1 m, 8 s)."""
    row = round(time / s.simulation.settings.dt)
    home, phase = s.place(s.q[0]), 2.0 * np.pi * time / 8.0
    return home + 0.1 * np.array([0.0, np.sin(phase), 1.0 - np.cos(phase)]) - s.place(s.q[row])


def first_over_half(s: Seen) -> int:
    return next(k for k, lam in enumerate(s.col("lambda")) if lam > 0.5)


def crossing(s: Seen, at: float) -> int:
    """First step after which d is on the other side of `at`."""
    d = s.col("d")
    return next(k for k in range(len(d) - 1) if (d[k] - at) * (d[k + 1] - at) <= 0.0)


def fall(s: Seen) -> int:
    """Step below d_m with the largest fall of d after it."""
    d = s.col("d")
    return max((k for k in range(len(d) - 1) if d[k] < 0.15), key=lambda k: d[k] - d[k + 1])


def slope(s: Seen, row: int) -> float:
    """n (u + w) / d*, with d* of line (R) for this step's u and w."""
    law, u, w = s.simulation.settings.law, s.col("u")[row], s.col("w_law")[row]
    rest = law.critical_distance * ((u + law.nominal_velocity) / (u + w)) ** (1.0 / law.order)
    return float(law.order * (u + w) / rest)


def length(s: Seen, row: int) -> float:
    return float(np.linalg.norm(s.lever(row)))


def euler_numbers(s: Seen) -> Array:
    """n λ (v + u) dt / d outside d_m."""
    d, u = (s.col(name)[s.col("d") >= 0.1] for name in ("d", "u"))
    return np.asarray(20.0 * (0.1 / d) ** 20 * (0.3 + u) * 0.02 / d)


def sideways(s: Seen) -> Array:
    """q_d − q of the slave."""
    joints = s.simulation.avoiding.joints
    return np.linalg.norm((s.simulation.history.desired(s.table) - s.q)[:, joints], axis=1)


TOP_SPEEDS = np.radians([110, 110, 128, 128, 204, 184, 184])

EXPECTED: dict[str, tuple[str, dict[str, Any], Callable[[Seen], float], float]] = {
    "distance_now": ("ball", {}, lambda s: s.gap(s.q[-1])[0], 1e-9),
    "smallest_distance": ("ball", {}, lambda s: min(s.gap(q)[0] for q in s.q), 1e-9),
    "distance_margin": ("ball", {}, lambda s: min(s.gap(q)[0] for q in s.q) - 0.15, 1e-9),
    "value_now": ("reach", {}, lambda s: s.least_singular(-1), 1e-6),
    "smallest_value": ("reach", {}, lambda s: min(s.least_singular(i) for i in range(len(s.q))), 1e-6),
    "value_margin": (
        "reach",
        {},
        lambda s: min(s.least_singular(i) for i in range(len(s.q))) - 0.1,
        1e-6,
    ),
    "distance_lost": (
        "push",
        {},
        lambda s: s.simulation.settings.law.critical_distance - min(s.col("d")),
        1e-9,
    ),
    "distance_at": ("ball", {"time": 4.0}, lambda s: s.gap(s.q[200])[0], 1e-9),
    "distance_swing": (
        "ball",
        {"since": 2.0, "until": 4.0},
        lambda s: float(np.ptp([s.gap(q)[0] for q in s.q[100:201]])),
        1e-9,
    ),
    "dead_time_number": ("ball", {"time": 4.0, "dead": 0.05}, lambda s: 0.05 * slope(s, 200), 1e-9),
    "way_made": (
        "ball",
        {"since": 2.0, "until": 4.0},
        lambda s: s.gap(s.q[100])[0] - s.gap(s.q[200])[0],
        1e-9,
    ),
    "largest_approach": ("push", {"within": 0.2}, lambda s: max(s.col("w")[s.col("d") < 0.2]), 0.0),
    "approach_now": ("push", {}, lambda s: s.col("w")[-1], 0.0),
    "pair_switches": ("wave", {}, lambda s: sum(a != b for a, b in pairwise(s.col("pair"))), 0.0),
    "lever_now": ("ball", {}, lambda s: length(s, -1), 1e-6),
    "smallest_lever": ("short", {}, lambda s: min(length(s, k) for k in range(len(s.table))), 1e-6),
    "textbook_speed": (
        "short",
        {},
        lambda s: max(0.3 * lam / length(s, k) for k, lam in enumerate(s.col("lambda"))),
        1e-4,
    ),
    "reached_speed": ("short", {}, lambda s: max(abs(x) for row in s.dq for x in row), 0.0),
    "speed_share": ("short", {}, lambda s: float((abs(s.dq).max(axis=0) / TOP_SPEEDS).max()), 1e-9),
    "time_without_authority": (
        "straight",
        {},
        lambda s: 0.01 * sum(a != 0 for a in s.col("authority")),
        1e-12,
    ),
    "joint_error_now": ("slave", {}, lambda s: s.col("e2")[-1] ** 0.5, 1e-9),
    "largest_joint_error": ("slave", {}, lambda s: max(s.col("e2")) ** 0.5, 1e-9),
    "joint_error_met": ("slave", {"distance": 0.25}, lambda s: sideways(s)[crossing(s, 0.25) + 1], 1e-12),
    "joint_error_beyond": ("slave", {"distance": 0.25}, lambda s: max(sideways(s)[s.col("d") > 0.25]), 1e-12),
    "null_dimension": ("pose", {}, lambda s: 7.0 - 6.0, 1e-6),
    "hand_error_now": (
        "ball",
        {},
        lambda s: float(np.linalg.norm(s.place(s.q[0]) + PATH - s.place(s.q[-1]))),
        1e-3,
    ),
    "largest_hand_error": ("ball", {"since": 3.0}, lambda s: max(s.col("e2")[150:]) ** 0.5, 1e-12),
    "mean_hand_error": ("ball", {}, lambda s: float(np.mean(np.sqrt(s.col("e2")))), 1e-12),
    "hand_error_at": (
        "tail",
        {"time": 7.5},
        lambda s: float(np.linalg.norm(s.place(s.q[0]) + PATH - s.place(s.q[375]))),
        1e-9,
    ),
    "elbow_travel": ("elbow", {}, lambda s: float(pdist(s.path("elbow")).max()), 1e-6),
    "hand_turned": (
        "elbow",
        {},
        lambda s: max(float(np.linalg.norm(pin.log3(s.turn(0).T @ s.turn(i)))) for i in range(len(s.q))),
        1e-6,
    ),
    "mark_miss": ("elbow", {"angle": 0.0}, lambda s: 0.0, 1e-12),
    "drift_per_lap": (
        "circle",
        {},
        lambda s: float(np.linalg.norm(circle_error(s, 16.0) - circle_error(s, 8.0))),
        1e-12,
    ),
    "joint_drift_per_lap": ("circle", {}, lambda s: float(np.linalg.norm(s.q[800] - s.q[400])), 1e-12),
    "lap_error": (
        "circle",
        {},
        lambda s: max(float(np.linalg.norm(circle_error(s, 0.02 * k))) for k in range(400, 801)),
        1e-9,
    ),
    "gain_step": ("circle", {}, lambda s: 0.5 * 0.02, 1e-12),
    "setting": ("circle", {"key": "dt"}, lambda s: 0.02, 0.0),
    "activation_now": ("ball", {}, lambda s: (0.15 / s.gap(s.q[-1])[0]) ** 2, 1e-9),
    "activation_met": ("ball", {"ratio": 1.5}, lambda s: 1.0 / 1.5**2, 2e-3),
    "activation_formula": ("ball", {"ratio": 3.0}, lambda s: 1.0 / 9.0, 1e-12),
    "pull_now": (
        "tail",
        {},
        lambda s: -2.0 * float((s.place(s.q[0]) + PATH - s.place(s.q[-1])) @ away(s)),
        2e-3,
    ),
    "rest_now": ("tail", {}, lambda s: 0.15 * ((s.col("u")[-1] + 0.3) / s.col("u")[-1]) ** 0.5, 1e-9),
    "stand_off_formula": ("tail", {"gap": 0.1}, lambda s: stand_off(), 1e-9),
    "bias_formula": ("tail", {"gap": 0.1}, lambda s: stand_off() - 0.1, 1e-9),
    "euler_number": ("steep", {}, lambda s: max(euler_numbers(s)), 1e-9),
    "loss_rate": ("push", {}, lambda s: (s.col("d")[fall(s)] - s.col("d")[fall(s) + 1]) / 0.005, 1e-9),
    "loss_formula": ("push", {}, lambda s: s.col("w")[fall(s)] - 0.3, 1e-9),
    "velocity_step": ("ball", {}, lambda s: max(abs(a - b).max() for a, b in pairwise(s.dq)), 0.0),
    "first_jump": (
        "switch",
        {},
        lambda s: float(np.linalg.norm(s.dq[first_over_half(s)] - s.dq[first_over_half(s) - 1])),
        0.0,
    ),
    "first_jump_formula": (
        "switch",
        {},
        lambda s: (0.3 + s.col("u")[(k := first_over_half(s))]) / length(s, k),
        1e-5,
    ),
    "switch_pull": ("switch", {}, lambda s: s.col("u")[first_over_half(s)], 0.0),
    "switch_lever": ("switch", {}, lambda s: length(s, first_over_half(s)), 1e-6),
    "zigzag": ("steep", {}, lambda s: looped_zigzag(s.col("d")), 0.0),
    "eigenvalue_now": ("beside", {}, lambda s: s.least(-1), 0.01),
    "least_eigenvalue": ("beside", {"since": 5.5}, lambda s: min(s.least(k) for k in range(275, 300)), 0.01),
    "rank_now": (
        "beside",
        {},
        lambda s: float(np.linalg.matrix_rank(np.vstack([s.lever(-1), s.hand_jacobian(-1)]), tol=1e-4)),
        0.0,
    ),
    "survival_now": ("beside", {}, lambda s: 1.0 - s.col("lambda")[-1] * s.rho(-1) ** 2, 1e-6),
    "way_to_stops": ("stops", {}, lambda s: min(s.to_stops(k) for k in range(len(s.q))), 1e-12),
    "singular_value": ("reach", {}, lambda s: min(s.least_singular(k) for k in range(len(s.q))), 1e-7),
    "coupling_now": (
        "beside",
        {},
        lambda s: float(np.linalg.norm(s.lever(-1) @ np.linalg.pinv(s.hand_jacobian(-1)))),
        1e-5,
    ),
}
"""Name → run, parameters, expected value, tolerance."""


def away(s: Seen) -> Array:
    """Unit vector from the ball to the hand at the end."""
    way = s.place(s.q[-1]) - s.q[-1][s.simulation.room.ball]
    return np.asarray(way / np.linalg.norm(way), np.float64)


def stand_off() -> float:
    """Solution d of λ v = (1 − λ) K (d − 0.1 m), the positive root of a cubic, for n = 2, v = 0.3 m/s,
    K = 2/s and d_m = 0.15 m."""
    return float(np.roots([2.0, -0.2, -2.0 * 0.15**2, 0.2 * 0.15**2 - 0.3 * 0.15**2]).real.max())


def test_every_measurement_is_tested() -> None:
    assert set(EXPECTED) == set(QUANTITIES)


@pytest.mark.parametrize("name", EXPECTED)
def test_measurement(name: str) -> None:
    run, parameters, expected, tolerance = EXPECTED[name]
    value = measure(Evidence(seen(run).simulation), name, tuple(parameters.items()))
    assert value is not None
    assert value == pytest.approx(expected(seen(run)), abs=max(tolerance, 1e-14), rel=1e-9)
    assert value != 0.0 or name == "mark_miss"
    quantity = QUANTITIES[name]
    assert shown_value(value, quantity.shown, quantity.digits)[0] in "0123456789−"


@pytest.mark.parametrize("scene", ["solo", "ball", "hold", "master_slave", "imitation"])
def test_a_run_without_steps_has_only_formula_values(scene: str) -> None:
    simulation = Simulation(setup(scene=scene).run, 10)
    asked = {name: tuple(parameters.items()) for name, (_, parameters, _, _) in EXPECTED.items()}
    told = {
        name
        for name, parameters in asked.items()
        if measure(Evidence(simulation), name, parameters) is not None
    }
    assert told == {"gain_step", "setting", "activation_formula", "stand_off_formula", "bias_formula"}, (
        "only values from settings exist before the first step"
    )
    for _ in range(3):
        simulation.step(None)
    for name, parameters in asked.items():
        measure(Evidence(simulation), name, parameters)
        measure(Evidence(simulation, newest=1), name, parameters)


def test_the_miss_of_a_mark_is_the_chord() -> None:
    """The elbow turns about 0.6 rad, a mark is at 0.9 rad; the miss is their chord on the elbow's circle."""
    s = seen("turned")
    data = s.simulation.room.model.createData()
    pin.forwardKinematics(s.simulation.room.model, data, s.q[0])
    arm = s.simulation.avoiding
    shoulder, elbow, wrist = (data.oMi[j].translation.copy() for j in (arm.shoulder, arm.elbow, arm.wrist))
    axis = (wrist - shoulder) / np.linalg.norm(wrist - shoulder)
    radial = elbow - shoulder - axis * float(axis @ (elbow - shoulder))
    offsets = s.path("elbow") - shoulder
    radials = offsets - np.outer(offsets @ axis, axis)
    turned = np.arctan2(np.cross(radial, radials) @ axis, radials @ radial)
    for mark in (-0.9, 0.9):
        chord = 2.0 * float(np.linalg.norm(radial)) * np.sin(np.abs(turned - mark).min() / 2.0)
        assert measure(Evidence(s.simulation), "mark_miss", (("angle", mark),)) == pytest.approx(
            chord, abs=1e-3
        )


def test_measuring_does_not_change_the_simulation() -> None:
    simulations = [Simulation(RUNS["ball"].run, 100) for _ in range(2)]
    for i in range(50):
        for simulation in simulations:
            simulation.step(None)
        if i % 10 == 0:
            for name, (_, parameters, _, _) in EXPECTED.items():
                measure(Evidence(simulations[0]), name, tuple(parameters.items()))
    assert (simulations[0].history.table() == simulations[1].history.table())[
        ~np.isnan(simulations[1].history.table())
    ].all()
    pose = simulations[0].kinematics.hand_pose(simulations[0].avoiding).translation.copy()
    assert (pose == simulations[1].kinematics.hand_pose(simulations[1].avoiding).translation).all()


def test_labels_show_the_critical_distance_with_an_index(approve: Approve) -> None:
    assert not [quantity.label for quantity in QUANTITIES.values() if "d_m" in quantity.label]
    approve("settings.txt", settings_text((("dm", 0.1), ("law", "strict_switched"))) + "\n")
