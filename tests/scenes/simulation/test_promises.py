"""Distance, reproducible bits and joint limits; reasons of lost authority; treatments of bounds."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from typing import get_args

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_array_equal

from controllers.choices import BoundsTreatment, Treatment
from controllers.kinematics import Array
from controllers.laws.situation import row_damping
from controllers.limits import Authority
from scenes.headless import Run, run, summarise
from scenes.history import COLUMN, Sample
from scenes.room import build_room
from scenes.settings import ArmName, LawSettings, RigName, RunSettings, changed
from scenes.simulation import Simulation
from scenes.targets import HandTarget
from tests.scenes.helpers import (
    RIG_NAMES,
    TREATMENTS,
    avoiding_hand,
    column,
    groups_of,
    guided_hand,
    hold_settings,
    inside_limits,
    overlapping_start,
    place_of,
    play,
    wander,
    with_law,
    with_values,
)

pytestmark = pytest.mark.slow


SEEDS = (2, 3, 6)
SCRIPT = 16.0
"""Length of a hold run [s]; the hand comes near, and seed 6 has dozens of switches of the closest pair."""


@cache
def hold_run(
    rig: RigName, seed: int, pairs: Treatment = "soft", law: str = "smooth_priority", dt: float = 0.005
) -> Run:
    """The hold scene with the autopilot; computed once for all tests, read-only."""
    return run(hold_settings(rig, seed, pairs, law, dt), SCRIPT)


@pytest.fixture(scope="module", autouse=True)
def _forgotten() -> Iterator[None]:
    """Free these runs, of about 10 MB each, for other files."""
    yield
    hold_run.cache_clear()


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("pairs", TREATMENTS)
def test_the_distance_is_kept(rig: RigName, seed: int, pairs: Treatment) -> None:
    finished = hold_run(rig, seed, pairs)
    chosen = hold_settings(rig, seed, pairs).law
    assert column(finished.table, "w").max() <= chosen.nominal_velocity
    assert finished.summary.d_min >= chosen.critical_distance - 1e-4
    assert finished.summary.d_min < chosen.critical_distance + 0.02
    assert finished.summary.share_below == 0.0 and finished.summary.e2_max > 0.01
    assert finished.summary.out_of_authority_s == 0.0


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize("seed", SEEDS)
def test_the_effects_of_the_law_and_of_the_smooth_minimum(rig: RigName, seed: int) -> None:
    # Positive control: without avoidance the same inputs make the arms collide, and the hand does not move.
    finished = hold_run(rig, seed, "single", "unprotected")
    assert finished.summary.d_min < 0.0 and finished.summary.e2_max < 1e-12
    guided = finished.simulation.guided.joints
    protected = hold_run(rig, seed, "single")
    history = finished.simulation.history
    assert_array_equal(
        history.positions(finished.table)[:, guided], history.positions(protected.table)[:, guided]
    )
    # No joint of the avoiding arm accelerates by over 5 rad/s², though the closest pair switches.
    finished = hold_run(rig, seed, "soft")
    assert finished.summary.ddq_max <= 5.0 and finished.summary.ddq_max > 0.1


@pytest.mark.parametrize("rig", RIG_NAMES)
def test_finer_steps_are_smooth_with_the_soft_minimum_and_jump_with_one_pair(
    rig: RigName,
) -> None:
    """Within 10 % at a quarter of dt. Control: with one pair the jump is as large at half the step."""
    coarse, fine, finest = (hold_run(rig, 6, "soft", dt=dt).summary for dt in (0.005, 0.0025, 0.00125))
    assert max(fine.ddq_max, finest.ddq_max) <= 1.1 * coarse.ddq_max
    rough, rougher = (hold_run(rig, 6, "single", dt=dt).summary for dt in (0.005, 0.0025))
    assert rough.dq_step_max > 0.05 and rougher.dq_step_max > 0.8 * rough.dq_step_max
    assert rougher.ddq_max > 1.6 * rough.ddq_max
    assert rougher.pair_switches > rough.pair_switches > 10
    assert fine.dq_step_max < 0.1 * rougher.dq_step_max


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize("pairs", TREATMENTS)
@pytest.mark.parametrize("guided", ["left", "right"])
def test_either_arm_leaves_contact(rig: RigName, pairs: Treatment, guided: ArmName) -> None:
    start = np.array(overlapping_start(rig))
    for law in ("smooth_priority", "unprotected"):
        simulation = Simulation(replace(hold_settings(rig, pairs=pairs, law=law), guided=guided))
        simulation.reset(start)
        assert simulation.sample().distance < -0.05
        distances = column(play(simulation, [None] * 400), "d")
        assert_array_equal(simulation.positions[simulation.guided.joints], start[simulation.guided.joints])
        if law == "unprotected":
            assert distances.max() < -0.05
        else:
            assert distances[200] >= 0.0 and np.flatnonzero(distances >= 0.0)[0] < 60
            assert distances[-1] >= simulation.settings.law.critical_distance - 1e-4
            assert np.diff(distances[:30]).min() > 0.0


@settings(max_examples=25)
@given(
    st.sampled_from(RIG_NAMES), st.sampled_from(["left", "right"]), st.sampled_from(TREATMENTS), st.sampled_from(["position", "pose"]),
    st.integers(0, 10_000), st.sampled_from([0.00125, 0.005, 0.02]), st.floats(0.05, 1.0), st.floats(0.3, 10.0), st.booleans(),
)  # fmt: skip
def test_joints_stay_finite_and_inside_their_limits(
    rig: RigName,
    guided: ArmName,
    pairs: Treatment,
    task: str,
    seed: int,
    dt: float,
    speed: float,
    reach: float,
    anywhere: bool,
) -> None:
    random = np.random.default_rng(seed)
    chosen = hold_settings(rig, pairs=pairs, dt=dt)
    simulation = Simulation(with_values(chosen, guided=guided, task=task, wmax=speed, k=20.0, g=40.0, v=1.0))
    model = simulation.room.model
    if anywhere:
        simulation.reset(random.uniform(model.lowerPositionLimit, model.upperPositionLimit))
    place = guided_hand(simulation)
    for _ in range(6):
        turn = pin.exp3(random.uniform(-2.0, 2.0, 3)) if random.random() < 0.5 else None
        elbow = place + random.uniform(-reach, reach, 3) if random.random() < 0.3 else None
        target = HandTarget(place + random.uniform(-reach, reach, 3), turn, elbow)
        for _ in range(20):
            simulation.step(target)
            assert inside_limits(simulation)
    table = simulation.history.table()
    assert np.isfinite(table[:, : COLUMN["e2_b"]]).all()
    assert np.isfinite(simulation.history.velocities(table)).all()
    assert np.abs(simulation.velocities[simulation.guided.joints]).max() > 0.0


@pytest.mark.parametrize("rig", RIG_NAMES)
def test_a_fast_person_reaches_the_stops(rig: RigName) -> None:
    simulation = Simulation(with_values(hold_settings(rig), wmax=1.0, v=1.0))
    model, closest = simulation.room.model, np.inf
    random = np.random.default_rng(2)
    for _ in range(25):
        target = HandTarget(avoiding_hand(simulation) + random.uniform(-1.0, 1.0, 3))
        for _ in range(120):
            simulation.step(target)
            q = simulation.positions
            closest = min(
                closest, float(np.minimum(q - model.lowerPositionLimit, model.upperPositionLimit - q).min())
            )
    assert -1e-12 <= closest < np.radians(1.0)


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize("pairs", TREATMENTS)
def test_replays_resets_and_a_ghost_in_the_same_room(rig: RigName, pairs: Treatment) -> None:
    # After any run a reset simulation repeats a fresh one to the bit.
    chosen = hold_settings(rig, pairs=pairs)
    used, fresh = Simulation(chosen), Simulation(chosen)
    targets = wander(fresh, 400)
    play(used, wander(used, 333, seed=9))
    used.reset()
    assert (used.time, used.steps, used.history.count) == (0.0, 0, 0)
    assert_array_equal(used.positions, fresh.positions)
    expected = play(fresh, targets)
    assert_array_equal(play(used, targets), expected)
    # A second simulation stepped in the same room changes no bit; without the law it moves differently.
    watched, ghost = Simulation(chosen), Simulation(with_law(chosen, law="unprotected"))
    for target in targets:
        watched.step(target)
        ghost.step(target)
    assert_array_equal(watched.history.table(), expected)
    assert not np.array_equal(ghost.history.table(), expected)


def test_resets_restore_the_initial_state() -> None:
    # Also after changes of rig, arm and every number.
    chosen = hold_settings("torso")
    used, fresh = Simulation(chosen), Simulation(chosen)
    for key, value in (
        ("rig", "table"),
        ("guided", "left"),
        ("g", 20.0),
        ("dt", 0.01),
        ("law", "unprotected"),
        ("task", "pose"),
    ):
        used.apply(changed(used.settings, key, value))
        play(used, wander(used, 20))
    used.apply(chosen)
    used.reset()
    targets = wander(fresh, 300)
    assert_array_equal(play(used, targets), play(fresh, targets))
    # The arms start at the given posture, and the given array is not changed.
    simulation = Simulation(hold_settings())
    start = np.array(overlapping_start("torso"))
    kept = start.copy()
    simulation.reset(start)
    assert_array_equal(simulation.positions, kept)
    play(simulation, wander(simulation, 50))
    assert_array_equal(start, kept)
    assert np.abs(simulation.positions - kept).max() > 0.01
    assert_array_equal(build_room("torso").start, Simulation(hold_settings()).positions)


def cornered(
    chosen: RunSettings, at_stops: bool, fits: Callable[[Array, Array], bool], tries: int = 3000
) -> Simulation:
    """A simulation at a posture that satisfies a condition of the avoiding arm's J_d and q.

    Args:
        at_stops: draw the avoiding arm's joints at their stops.
        fits: condition of J_d (7,) and q (7,) of the avoiding arm.
    """
    simulation = Simulation(chosen)
    model, joints, random = simulation.room.model, simulation.avoiding.joints, np.random.default_rng(8)
    lower, upper = model.lowerPositionLimit, model.upperPositionLimit
    for _ in range(tries):
        q = random.uniform(lower, upper)
        if at_stops:
            q[joints] = np.where(random.random(7) < 0.5, lower[joints], upper[joints])
        simulation.kinematics.update(q)
        near = simulation.detector.detect("single")
        if near.distance < chosen.law.critical_distance and fits(near.row[joints], q[joints]):
            simulation.reset(q)
            return simulation
    raise AssertionError("found no such posture")


FAST = with_law(hold_settings("table", pairs="single"), critical_distance=0.30, nominal_velocity=1.0)


def row_of(simulation: Simulation, sample: Sample) -> Array:
    """The avoiding arm's J_d (7,) of the closest pair at a sample."""
    simulation.kinematics.update(sample.positions)
    return simulation.detector.detect("single").row[simulation.avoiding.joints].copy()


def reach_of(simulation: Simulation, row: Array, q: Array) -> tuple[float, float]:
    """Largest retreats of the avoiding arm allowed by its top speeds, and by its stops, too [m/s]."""
    joints, model = simulation.avoiding.joints, simulation.room.model
    top, g = model.velocityLimit[joints], simulation.settings.limit_gain
    way = np.where(row > 0.0, model.upperPositionLimit[joints] - q, q - model.lowerPositionLimit[joints])
    return float(np.abs(row) @ top), float(np.abs(row) @ np.minimum(top, g * way))


def test_bounds_are_reported_as_the_reason() -> None:
    # A retreat of 1 m/s beyond all top speeds: SPEED, the most important joint, and the largest rate.
    probe = Simulation(FAST)

    def slow(row: Array, q: Array) -> bool:
        fastest, left = reach_of(probe, row, q)
        return float(np.linalg.norm(row)) > 0.2 and left > fastest - 1e-9 and fastest < 0.9

    simulation = cornered(FAST, False, slow)
    simulation.step(None)
    sample = simulation.sample()
    assert sample.authority == Authority.SPEED
    dq, top = sample.velocities[simulation.avoiding.joints], simulation.room.model.velocityLimit[:7]
    row = row_of(simulation, sample)
    assert sample.joint == int(np.abs(row).argmax())
    assert abs(dq[sample.joint]) == pytest.approx(top[sample.joint])
    # The largest possible rate, except for joints that hardly move the point: the rest of the row is damped.
    assert float(row @ dq) == pytest.approx(float(np.abs(row) @ top), rel=0.02)
    assert float(row @ dq) < 1.0

    # Joints at stops that they would have to pass: STOP, and a joint that rests at its stop.
    def blocked(row: Array, q: Array) -> bool:
        fastest, left = reach_of(probe, row, q)
        return fastest > 1.2 and left < 0.8

    simulation = cornered(FAST, True, blocked)
    simulation.step(None)
    sample = simulation.sample()
    assert sample.authority == Authority.STOP
    joints, model = simulation.avoiding.joints, simulation.room.model
    q, upper = sample.positions[joints], model.upperPositionLimit[joints]
    assert abs(q[sample.joint]) == pytest.approx(upper[sample.joint])
    assert sample.velocities[joints][sample.joint] == pytest.approx(0.0, abs=1e-9)
    assert float(row_of(simulation, sample) @ sample.velocities[joints]) < 0.9
    assert inside_limits(simulation)


def short_lever(row: Array, _: Array) -> bool:
    """True if damping leaves less than half of the wanted rate."""
    square = float(row @ row)
    return 1e-4 < square < 0.8 * row_damping(square)


LEVER = with_law(hold_settings("table", pairs="single"), critical_distance=0.30, nominal_velocity=0.05)


def test_a_missing_lever_is_reported_as_the_reason() -> None:
    # An approach that no joint can evade, J_d nearly 0: LEVERAGE; with a normal lever at the same d: FULL.
    simulation = cornered(LEVER, False, short_lever)
    simulation.step(None)
    assert simulation.sample().authority == Authority.LEVERAGE
    assert simulation.sample().joint == -1
    assert summarise(simulation, simulation.history.table()).out_of_authority_s == simulation.settings.dt
    able = cornered(
        LEVER, False, lambda row, q: float(np.linalg.norm(row)) > 0.3 and float(np.abs(q).max()) < 1.5
    )
    able.step(None)
    assert able.sample().authority == Authority.FULL
    # At λ = 1, with a task at top speed that still pulls closer, authority is not FULL.
    simulation = cornered(LEVER, False, short_lever)
    simulation.apply(changed(simulation.settings, "k", 20.0))
    missed = 0
    for away in np.random.default_rng(1).uniform(-0.6, 0.6, (30, 3)):
        simulation.reset(simulation.positions.copy())
        place_of(simulation)[:] += away
        simulation.step(None)
        sample, joints = simulation.sample(), simulation.avoiding.joints
        simulation.positions[:] = sample.positions
        at_top = bool(
            (np.abs(sample.velocities[joints]) >= simulation.room.model.velocityLimit[joints] - 1e-9).any()
        )
        row = row_of(simulation, sample)
        if at_top and sample.activation == 1.0 and float(row @ sample.velocities[joints]) < 0.0:
            missed += 1
            assert sample.authority != Authority.FULL
    assert missed > 5


TIGHT = RunSettings(
    gain=20.0, hand_speed=1.0, limit_gain=2.0, law=LawSettings(nominal_velocity=1.0, critical_distance=0.3)
)
BOUNDS_TREATMENTS: tuple[BoundsTreatment, ...] = get_args(BoundsTreatment)


def pushed(treatment: BoundsTreatment, steps: int = 500, scene: str = "hold") -> Simulation:
    """A run with a fast motion of the guided hand to the other one."""
    simulation = Simulation(replace(TIGHT, bounds=treatment, scene=scene))
    place = simulation.kinematics.hand_pose(simulation.avoiding).translation.copy()
    for _ in range(steps):
        simulation.step(HandTarget(place))
    return simulation


@pytest.mark.parametrize("scene", ["hold", "master_slave"])
@pytest.mark.parametrize("treatment", BOUNDS_TREATMENTS)
def test_no_treatment_exceeds_a_bound(treatment: BoundsTreatment, scene: str) -> None:
    simulation = pushed(treatment, scene=scene)
    table, model = simulation.history.table(), simulation.room.model
    q, dq = simulation.history.positions(table), simulation.history.velocities(table)
    assert (q >= model.lowerPositionLimit - 1e-9).all() and (q <= model.upperPositionLimit + 1e-9).all()
    assert (np.abs(dq) <= model.velocityLimit + 1e-9).all()


def test_each_treatment_keeps_its_part_of_a_laws_velocity() -> None:
    """The distance rate; the direction; the distance rate and, if possible, the hand's velocity."""
    simulation = pushed("distance", 60)
    group = groups_of(simulation)[0]
    row = simulation.detector.detect("soft", 100.0).row[group.joints]
    J = simulation.roles.task.task_jacobian
    assert J is not None
    rng = np.random.default_rng(0)
    better = 0
    for _ in range(40):
        wanted = rng.uniform(-1.3, 1.3, 7) * simulation.room.model.velocityLimit[group.joints]
        kept, short, both = (group.bounded(row, wanted, treatment) for treatment in BOUNDS_TREATMENTS)
        assert all(group.box.contains(bounded.velocities) for bounded in (kept, short, both))
        assert float(row @ both.velocities) == pytest.approx(float(row @ kept.velocities), abs=1e-7)
        assert_parallel(short.velocities, wanted)
        lost = [float(np.linalg.norm(J @ (bounded.velocities - wanted))) for bounded in (kept, both)]
        assert lost[1] <= lost[0] + 1e-7
        better += lost[1] < 1e-7 < 1e-3 < lost[0]
    assert better > 4


def assert_parallel(one: np.ndarray, other: np.ndarray) -> None:
    assert float(one @ other) == pytest.approx(float(np.linalg.norm(one) * np.linalg.norm(other)), rel=1e-12)


def test_null_space_saturation_keeps_the_distance_and_the_hand_better() -> None:
    """The distance rate has priority: d is no smaller than by default, and the hand's error is smaller."""
    default, saturating = (pushed(treatment, 800).history.table() for treatment in ("distance", "null_space"))
    d, e = COLUMN["d"], COLUMN["e2"]
    assert saturating[:, d].min() > default[:, d].min() - 1e-3
    assert saturating[:, e].mean() < default[:, e].mean()
