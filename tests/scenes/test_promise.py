"""The promise d ≥ d_law ≥ d_m and line (R), ḋ = λ v − (1 − λ) u − w, in runs of the real arms."""

import csv
import io
import math
from dataclasses import replace
from typing import get_args

import numpy as np
import pytest

from controllers import budget
from controllers.activation import activation
from controllers.choices import Treatment
from controllers.kinematics import Array, Kinematics
from controllers.laws.situation import AUTHORITY, Situation
from controllers.laws.smooth_priority import SmoothPriority
from controllers.limits import Authority
from controllers.proximity import ProximityDetector
from scenes.hardware import Actuation, before_stops
from scenes.headless import Run, run
from scenes.laws import LAWS
from scenes.promise import Condition, broken_by, missing, missing_now
from scenes.random_draws import random_run
from scenes.recording import write_table
from scenes.room import World, build_room
from scenes.settings import HardwareSettings, RigName, RunSettings
from scenes.simulation import Simulation
from tests.scenes.helpers import RIG_NAMES, SCENES, column, given_settings, with_law, with_values

BETWEEN = given_settings(start="between", avoid="guided", seed=396, v=0.05, pairs="single")


def columns(done: Run) -> dict[str, Array]:
    """Number columns of a run's CSV file by name."""
    out = io.StringIO()
    write_table(out, done.simulation, done.table, {})
    rows = list(csv.DictReader(line for line in out.getvalue().splitlines() if not line.startswith("#")))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0] if name != "pair"}


@pytest.mark.parametrize("scene", SCENES[1:])
@pytest.mark.parametrize("pairs", get_args(Treatment))
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_columns_of_any_run_give_the_rate(scene: str, pairs: Treatment, seed: int) -> None:
    """J_d q̇ from the q and q̇ columns is the sum of s λ (v + u) − u of the avoiding arms, minus w."""
    drawn = replace(random_run(7, seed).settings, hardware=HardwareSettings())
    settings = with_values(drawn, scene=scene, pairs=pairs, law="smooth_priority", dt=0.01, together="ratios")
    done = run(settings, 2.0)
    law, found, room = settings.law, columns(done), done.simulation.room
    lam = np.array([activation(d, law.critical_distance, law.order) for d in found["law_d"]])
    np.testing.assert_allclose(lam, column(done.table, "lambda"), rtol=0.0, atol=1e-12)
    q, dq = (np.column_stack([found[name.format(what)] for name in room.columns]) for what in ("q", "dq"))
    world, rates, distances = World(room, settings.limit_gain), [], []
    for positions, velocities in zip(q, dq, strict=True):
        world.kinematics.update(positions)
        near = world.detector.detect(law.pairs, law.beta, law.convexity)
        rates.append(float(near.row.dot(velocities)))
        distances.append(near.law_distance)
    np.testing.assert_allclose(distances, found["law_d"], rtol=0.0, atol=1e-12)
    two = "u_b" in found
    expected = np.zeros(len(lam)) if two else -found["w_law"]
    for end in ("", "_b") if two else ("",):
        wanted = law.nominal_velocity + found[f"u{end}"] + (found[f"w_law{end}"] if law.feed_forward else 0.0)
        expected += (
            found[f"lever{end}"] * lam * (np.maximum(wanted, 0.0) if law.one_sided else wanted)
            - found[f"u{end}"]
        )
    free = np.ones(len(lam), bool)
    for end in ("", "_b") if two else ("",):
        free &= ~np.isin(column(done.table, f"authority{end}"), (Authority.STOP, Authority.SPEED))
    assert free.sum() > 20
    off = np.abs(np.array(rates) - expected)[free]
    # At a bound the rate is reached within `controllers.limits.TOLERANCE`.
    assert off.max() < 4e-6
    assert np.median(off) < 1e-12


def test_between_two_pairs_the_broken_promise_is_explained_by_the_pairs() -> None:
    done = run(BETWEEN, 8.0)
    law_d = column(done.table, "law_d")
    lost = missing(BETWEEN, done.table)
    assert law_d.min() < BETWEEN.law.critical_distance - 0.1
    assert {condition for condition, steps in lost.items() if steps.any()} == {Condition.PAIRS}
    assert missing_now(BETWEEN, done.simulation.history) == (Condition.PAIRS,)
    assert broken_by(BETWEEN, done.table) < 1e-3
    # The same table without the condition on pairs.
    assert broken_by(with_law(BETWEEN, pairs="soft"), done.table) > 0.1
    for pairs in ("soft", "smooth"):
        cured = with_law(BETWEEN, pairs=pairs)
        done = run(cured, 8.0)
        assert column(done.table, "law_d").min() > cured.law.critical_distance
        assert not any(steps.any() for steps in missing(cured, done.table).values())
        assert missing_now(cured, done.simulation.history) == ()


@pytest.mark.parametrize(
    ("settings", "expected"),
    [(given_settings(wmax=0.8, v=0.05, seed=3), Condition.SPEED), (BETWEEN, Condition.PAIRS)],
    ids=lambda value: getattr(value, "name", ""),
)
def test_the_page_and_the_table_agree_at_every_step(settings: RunSettings, expected: Condition) -> None:
    """The live result at a step equals the table's, except for a later switch of pairs."""
    simulation = Simulation(settings)
    person, seen = simulation.source(), []
    while simulation.time < 8.0:
        simulation.step(person.target(simulation.time))
        seen.append(missing_now(settings, simulation.history))
    whole = missing(settings, simulation.history.table())
    for condition in (Condition.SPEED, Condition.LEVER, Condition.BOUND):
        assert [condition in now for now in seen] == whole[condition].tolist()
    assert any(expected in now for now in seen) and () in seen
    known = np.array([Condition.PAIRS in now for now in seen])
    assert not np.any(known & ~whole[Condition.PAIRS])


def test_an_empty_history_misses_nothing_and_one_law_makes_the_promise() -> None:
    assert missing_now(BETWEEN, Simulation(BETWEEN).history) == ()
    assert [name for name, law in LAWS.items() if law.promises] == ["smooth_priority"]


class Contact:
    """Two real arms with a fixed pair of bodies; left avoids, right approaches."""

    def __init__(
        self, rig: RigName, law: SmoothPriority, first: str = "hand", second: str = "forearm"
    ) -> None:
        self.room, self.law = build_room(rig), law
        self.kinematics = Kinematics(self.room.model, self.room.arms)
        self.detector = ProximityDetector(self.kinematics, self.room.geometry)
        self.pair = self.detector.pair_names.index((f"left {first}", f"right {second}"))
        self.left, self.right = self.room.arms[0].joints, self.room.arms[1].joints
        self.q = self.room.start.copy()
        self.row = np.zeros(self.room.model.nv)

    def measure(self) -> float:
        self.kinematics.update(self.q)
        self.detector.detect()
        self.row = self.detector.row(self.pair)
        for joints in (self.left, self.right):
            assert np.linalg.norm(self.row[joints]) > AUTHORITY
        return float(self.detector.distances()[self.pair])

    def along(self, joints: slice, speed: float) -> Array:
        """Smallest velocity (7,) of an arm that changes d at `speed` [m/s]."""
        row = self.row[joints]
        return row * (speed / row.dot(row))

    def start_at(self, distance: float) -> None:
        for _ in range(100):
            missing = distance - self.measure()
            step = float(np.clip(missing, -0.02, 0.02)) / 2.0
            self.q[self.left] += self.along(self.left, step)
            self.q[self.right] += self.along(self.right, step)
            if abs(missing) < 1e-12:
                break
        assert self.measure() == pytest.approx(distance, abs=1e-9)

    def avoiding(self, joints: slice, distance: float, pull: float, approach: float, aside: float) -> Array:
        """The law's q̇ for a task that pulls with u and also moves across the row."""
        row = self.row[joints]
        wander = aside * np.cos(np.arange(7.0))
        nominal = self.along(joints, -pull) + wander - self.along(joints, float(row @ wander))
        return self.law(Situation(self.q[joints], nominal, row, distance, approach))

    def run(
        self,
        steps: int,
        dt: float,
        pull: float,
        approach: float = 0.0,
        aside: float = 0.0,
        both: float | None = None,
    ) -> Array:
        """d (steps + 1,): the left arm avoids, the right one approaches with w or avoids a pull, too."""
        path = [self.measure()]
        for _ in range(steps):
            left, right = (
                self.avoiding(self.left, path[-1], pull, approach, aside),
                self.along(self.right, -approach),
            )
            if both is not None:
                right = self.avoiding(self.right, path[-1], both, 0.0, 0.0)
            self.q[self.left] += left * dt
            self.q[self.right] += right * dt
            path.append(self.measure())
        return np.array(path)


DM, V = 0.15, 0.3


def contact_at(
    rig: RigName, distance: float, n: float, v: float = V, dm: float = DM, fed: bool = False
) -> Contact:
    contact = Contact(rig, SmoothPriority(dm, n, v, feed_forward=fed))
    contact.start_at(distance)
    return contact


STILL = [(n, u, 0.0) for n, u in ((2.0, 0.2), (6.0, 0.05), (6.0, 0.2), (10.0, 0.2), (20.0, 0.4))]
COMING = [(6.0, 0.1, 0.1), (10.0, 0.0, 0.2), (10.0, 0.2, 0.25), (20.0, -0.05, 0.15)]


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize(("n", "u", "w"), STILL + COMING)
def test_the_arm_rests_at_the_closed_form_from_both_sides(rig: RigName, n: float, u: float, w: float) -> None:
    """Within 1 mm of d*; with an obstacle of w ≤ v, from farther away, d never falls below d_m."""
    rest, tau = budget.resting_distance(DM, n, V, u, w), budget.settling_time(DM, n, V, u, w)
    dt = min(0.1 * tau, 0.005 if w else 0.02)
    for start in (rest + 0.01,) if w else (rest - 0.02, rest + 0.02):
        path = contact_at(rig, start, n).run(round(5.0 * tau / dt), dt, u, w)
        assert path[-1] == pytest.approx(rest, abs=1e-3)
        assert not w or path.min() >= DM


@pytest.mark.parametrize("rig", RIG_NAMES)
def test_motion_aside_and_fed_forward(rig: RigName) -> None:
    # A task that also moves quickly across the row rests at the same d*, with other joint angles.
    n, u = 10.0, 0.2
    rest, tau = budget.resting_distance(DM, n, V, u), budget.settling_time(DM, n, V, u)
    ends = []
    for aside in (0.0, 0.3):
        contact = contact_at(rig, rest + 0.01, n)
        assert contact.run(round(5.0 * tau / 0.001), 0.001, u, aside=aside)[-1] == pytest.approx(
            rest, abs=1e-3
        )
        ends.append(contact.q)
    assert np.abs(ends[1] - ends[0]).max() > 0.05
    # With w fed forward d ≥ d_m at w = 2 v, as line (R) with v + w; the plain law fails (control).
    u, w = 0.1, 0.6
    fed, plain = (contact_at(rig, 0.16, n, fed=fed).run(300, 0.0005, u, w) for fed in (True, False))
    assert fed.min() >= DM > plain.min()
    assert fed[-1] == pytest.approx(budget.resting_distance(DM, n, V + w, u, w), abs=1e-3)


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize(("u", "w"), [(0.2, 0.28), (0.2, 0.30), (0.2, 0.32), (-0.1, 0.45), (1.0, 0.45)])
def test_the_distance_falls_by_the_excess_speed_of_the_obstacle(rig: RigName, u: float, w: float) -> None:
    """d_m is kept if and only if w ≤ v; below d_m the distance falls at w − v for any u, within 1 mm/s."""
    assert bool(contact_at(rig, 0.16, 10.0).run(300, 0.001, u, w).min() >= DM - 1e-4) is (w <= V)
    if w > V:
        path = contact_at(rig, 0.14, 6.0).run(300, 0.0005, u, w)
        assert np.abs(np.diff(path) / 0.0005 + (w - V)).max() < 1e-3


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize(("v", "pulls"), [(0.05, (0.2, 0.3)), (0.3, (0.2, 0.2)), (0.3, (0.4, -0.1))])
def test_both_arms(rig: RigName, v: float, pulls: tuple[float, float]) -> None:
    """d never passes d_m for any v > 0, and each step's rate is 2 λ v − (1 − λ)(u_1 + u_2)."""
    n, dt = 10.0, 0.001
    path = contact_at(rig, 0.17, n, v).run(500, dt, pulls[0], both=pulls[1])
    assert path.min() >= DM
    lam = np.minimum(1.0, (DM / path[:-1]) ** n)
    assert np.abs(np.diff(path) / dt - (2.0 * lam * v - (1.0 - lam) * sum(pulls))).max() < 1e-3


N, U = 20.0, 0.4
REST, TAU = budget.resting_distance(DM, N, V, U), budget.settling_time(DM, N, V, U)
NEAR = 1e-4
"""Start offset from the rest [m], within the linear range."""


def late_run(
    contact: Contact, steps: int, dt: float, hardware: HardwareSettings, approach: float = 0.0
) -> Array:
    """d (steps + 1,): the left arm avoids with dead time and lag, the right one approaches with w."""
    path, actuation = [contact.measure()], Actuation(len(contact.q))
    velocities = np.zeros_like(contact.q)
    for step in range(steps):
        command = np.zeros_like(velocities)
        command[contact.left] = contact.avoiding(contact.left, path[-1], U, approach, 0.0)
        velocities = actuation.reached(hardware, command, velocities, step * dt, dt)
        contact.q[contact.left] += velocities[contact.left] * dt
        contact.q[contact.right] += contact.along(contact.right, -approach) * dt
        path.append(contact.measure())
    return np.array(path)


def swings(path: Array) -> tuple[float, float]:
    """Largest deviations from the rest in the second and last fifth of a path [m]."""
    away, fifth = np.abs(path - REST), len(path) // 5
    return float(away[fifth : 2 * fifth].max()), float(away[-fifth:].max())


def test_limits_of_the_dead_time() -> None:
    assert budget.largest_dead_time(TAU) == pytest.approx(0.5 * math.pi * TAU)
    assert budget.largest_dead_time_without_overshoot(TAU) == pytest.approx(TAU / math.e)
    # A lag of 1 µs has no effect, and a lag alone never makes it unstable.
    assert budget.largest_dead_time(TAU, 1e-6) == pytest.approx(budget.largest_dead_time(TAU), rel=1e-3)
    assert (
        0.0
        < budget.largest_dead_time(TAU, 0.1)
        < budget.largest_dead_time(TAU, 0.01)
        < budget.largest_dead_time(TAU)
    )
    assert budget.largest_dead_time(math.inf, 0.01) == math.inf


@pytest.mark.parametrize(
    ("rig", "lag"), [("torso", 0.0), ("table", 0.0), ("torso", 0.2 * TAU), ("torso", 2.0 * TAU)]
)
def test_a_dead_time_oscillates_beyond_the_closed_form_also_with_a_lag(rig: RigName, lag: float) -> None:
    """40 steps per dead time are nearly continuous. Without a lag the overshoot matches its closed form."""
    allowed, calm, late = (
        budget.largest_dead_time(TAU, lag),
        budget.largest_dead_time_without_overshoot(TAU),
        40,
    )

    def run_of(dead_time: float) -> Array:
        hardware = HardwareSettings(dead_time=dead_time, lag=lag)
        return late_run(contact_at(rig, REST + NEAR, N), 900, dead_time / late, hardware)

    for share, grows in ((0.85, False), (1.15, True)):
        earlier, later = swings(run_of(share * allowed))
        assert (later > 1.2 * earlier) is grows
        assert (later < 0.8 * earlier) is not grows
    for share, overshoots in ((0.85, False), (1.3, True)) if not lag else ():
        assert bool(run_of(share * calm).min() < REST - 1e-3 * NEAR) is overshoots


@pytest.mark.parametrize("rig", RIG_NAMES)
def test_a_sudden_start_costs_the_speed_times_the_dead_time(rig: RigName) -> None:
    dt, w, T = 0.001, 0.2, 0.05
    path = late_run(
        contact_at(rig, REST, N), round(2.0 * T / dt), dt, HardwareSettings(dead_time=T), approach=w
    )
    lost = REST - path[round(T / dt)]
    assert lost == pytest.approx(w * T, rel=0.01)
    # The ideal robot reacts at once.
    ideal = late_run(contact_at(rig, REST, N), round(T / dt), dt, HardwareSettings(), approach=w)
    assert REST - ideal[-1] < 0.5 * lost
    assert ideal.min() > DM > path.min()


def test_a_lag_is_exact_for_a_constant_command() -> None:
    command, lag = np.array([1.0, -2.0]), 0.03
    for dt in (0.001, 0.005, 0.02):
        actuation, velocities, way = Actuation(2), np.zeros(2), np.zeros(2)
        steps = round(0.06 / dt)
        for step in range(steps):
            velocities = actuation.reached(HardwareSettings(lag=lag), command, velocities, step * dt, dt)
            way += velocities * dt
        assert actuation.memory()[-1] == pytest.approx(command * (1.0 - math.exp(-0.06 / lag)), rel=1e-12)
        assert way == pytest.approx(command * (0.06 - lag * (1.0 - math.exp(-0.06 / lag))), rel=1e-12)


def test_a_stop_holds_a_lagging_joint() -> None:
    lower, upper = np.array([-1.0, -1.0, -1.0]), np.array([1.0, 1.0, 1.0])
    q = np.array([0.999, 0.0, -1.001])
    held = before_stops(np.array([0.5, 0.5, -0.5]), q, lower, upper, 0.01)
    assert held == pytest.approx([0.1, 0.5, 0.0])
    # A joint beyond its stop may return.
    assert before_stops(np.array([0.5, 0.5, 0.5]), q, lower, upper, 0.01)[2] == 0.5
