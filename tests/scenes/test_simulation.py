"""The loop: what it promises about distance, smoothness and limits, and that the same inputs always give the same bits."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from controllers.kinematics import Array
from controllers.laws.situation import row_damping
from controllers.limits import Authority
from controllers.proximity import Treatment
from scenes.autopilot import Autopilot
from scenes.headless import FELT, run, summarise
from scenes.history import COLUMN, SCALARS, History, Sample
from scenes.room import build_room
from scenes.settings import ArmName, RigName, RunSettings, changed
from scenes.simulation import Simulation
from scenes.targets import HandTarget
from tests.scenes.helpers import (
    RIG_NAMES,
    avoiding_hand,
    column,
    guided_hand,
    hold_run,
    hold_settings,
    overlapping_start,
    place_of,
    play,
    true_distance,
    wander,
    with_law,
)

SEEDS = (1, 2, 3)
TREATMENTS: tuple[Treatment, ...] = ("single", "soft")


def inside_limits(simulation: Simulation) -> bool:
    """Whether all joints are finite and inside their stops, and no faster than they can be."""
    model, q, dq = simulation.room.model, simulation.positions, simulation.velocities
    inside = (q >= model.lowerPositionLimit - 1e-12).all() and (q <= model.upperPositionLimit + 1e-12).all()
    return bool(np.isfinite(q).all() and inside and (np.abs(dq) <= model.velocityLimit + 1e-12).all())


# ---- the promise: distance ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("pairs", TREATMENTS)
def test_the_distance_is_kept(rig: RigName, seed: int, pairs: Treatment) -> None:
    """Over 46 s of a person no faster than v, the arms never get closer than d_m; and the person did come close."""
    finished = hold_run(rig, seed, pairs)
    chosen = hold_settings(rig, seed, pairs).law
    assert column(finished.table, "w").max() <= chosen.nominal_velocity
    assert finished.summary.d_min >= chosen.critical_distance - 1e-4
    assert finished.summary.d_min < chosen.critical_distance + 0.02
    assert finished.summary.share_below == 0.0
    assert finished.summary.e2_max > 0.01
    assert finished.summary.out_of_authority_s == 0.0


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize("seed", SEEDS)
def test_unprotected_the_same_person_collides(rig: RigName, seed: int) -> None:
    """Positive control: the same inputs without avoidance drive the arms into each other, and the hand does not move at all."""
    finished = hold_run(rig, seed, "single", "unprotected")
    assert finished.summary.d_min < 0.0
    assert finished.summary.e2_max < 1e-12
    guided = finished.simulation.guided.joints
    protected = hold_run(rig, seed, "single")
    history = finished.simulation.history
    assert_array_equal(history.positions(finished.table)[:, guided], history.positions(protected.table)[:, guided])


# ---- the promise: smoothness --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize("seed", SEEDS)
def test_the_smooth_minimum_is_smooth(rig: RigName, seed: int) -> None:
    """No joint of the avoiding arm is accelerated by more than 5 rad/s², though the closest pair switches."""
    finished = hold_run(rig, seed, "soft")
    assert finished.summary.ddq_max <= 5.0
    assert finished.summary.ddq_max > 0.1


@pytest.mark.parametrize(("rig", "seed"), [("torso", 2), ("table", 3)])
def test_its_acceleration_does_not_grow_with_a_finer_step(rig: RigName, seed: int) -> None:
    """Halving dt twice leaves the largest acceleration within 10 %: it belongs to the motion, not to the step."""
    coarse, fine, finest = (hold_run(rig, seed, "soft", dt=dt).summary.ddq_max for dt in (0.005, 0.0025, 0.00125))
    assert fine <= 1.1 * coarse
    assert finest <= 1.1 * coarse


@pytest.mark.parametrize(("rig", "seed"), [("table", 3), ("torso", 2)])
def test_the_closest_pair_alone_jumps(rig: RigName, seed: int) -> None:
    """Positive control, and the paper's limit: in a concave corner q̇ jumps when the pair switches, by as much at half the step."""
    coarse, fine = (hold_run(rig, seed, "single", dt=dt).summary for dt in (0.005, 0.0025))
    assert coarse.dq_step_max > 0.05
    assert fine.dq_step_max > 0.8 * coarse.dq_step_max
    assert fine.ddq_max > 1.6 * coarse.ddq_max
    assert fine.pair_switches > coarse.pair_switches > 10
    soft = hold_run(rig, seed, "soft", dt=0.0025).summary
    assert soft.dq_step_max < 0.1 * fine.dq_step_max


# ---- starting inside ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize("pairs", TREATMENTS)
def test_it_gets_out_of_contact(rig: RigName, pairs: Treatment) -> None:
    """Put down 5 cm inside each other, the arms are apart within 1 s and clear of d_m within 2 s; unprotected they stay."""
    start = np.array(overlapping_start(rig))
    for law in ("smooth_priority", "unprotected"):
        simulation = Simulation(hold_settings(rig, pairs=pairs, law=law))
        simulation.reset(start)
        assert simulation.sample().distance < -0.05
        distances = column(play(simulation, [None] * 400), "d")
        if law == "unprotected":
            assert distances.max() < -0.05
        else:
            assert distances[200] >= 0.0
            assert np.flatnonzero(distances >= 0.0)[0] < 60
            assert distances[-1] >= simulation.settings.law.critical_distance - 1e-4
            assert np.diff(distances[:30]).min() > 0.0


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize("guided", ["left", "right"])
def test_it_gets_out_whoever_has_to_move(rig: RigName, guided: ArmName) -> None:
    """Either arm can be the one that yields."""
    simulation = Simulation(replace(hold_settings(rig), guided=guided))
    simulation.reset(np.array(overlapping_start(rig)))
    still = simulation.positions[simulation.guided.joints].copy()
    assert column(play(simulation, [None] * 250), "d")[-1] > 0.1
    assert_array_equal(simulation.positions[simulation.guided.joints], still)


# ---- the same bits ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize("pairs", TREATMENTS)
def test_a_replay_is_bit_identical(rig: RigName, pairs: Treatment) -> None:
    """Same settings and inputs, same table; another d_m, another table (positive control)."""
    chosen = hold_settings(rig, pairs=pairs)
    tables = [play(simulation := Simulation(chosen), wander(simulation, 400)) for _ in range(2)]
    assert_array_equal(tables[0], tables[1])
    other = Simulation(with_law(chosen, critical_distance=0.2))
    assert not np.array_equal(play(other, wander(other, 400)), tables[0])


@pytest.mark.parametrize("rig", RIG_NAMES)
def test_a_ghost_does_not_disturb(rig: RigName) -> None:
    """A second simulation in the same room, stepped in between, changes no bit of the first."""
    alone, watched, ghost = (Simulation(hold_settings(rig, law=law)) for law in ("smooth_priority",) * 2 + ("unprotected",))
    targets = wander(alone, 300)
    expected = play(alone, targets)
    for target in targets:
        watched.step(target)
        ghost.step(target)
    assert_array_equal(watched.history.table(), expected)
    assert not np.array_equal(ghost.history.table(), expected)


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize("pairs", TREATMENTS)
def test_reset_equals_a_fresh_start(rig: RigName, pairs: Treatment) -> None:
    """After any run, in any mood of the guide, a reset simulation does bit for bit what a fresh one does."""
    chosen = hold_settings(rig, pairs=pairs)
    used, fresh = Simulation(chosen), Simulation(chosen)
    targets = wander(fresh, 300)
    play(used, wander(used, 333, seed=9))
    used.reset()
    assert (used.time, used.steps, used.history.count) == (0.0, 0, 0)
    assert_array_equal(used.positions, fresh.positions)
    assert_array_equal(play(used, targets), play(fresh, targets))


def test_reset_after_many_changes_equals_a_fresh_start() -> None:
    """Also after the rig, the arm, and every number were changed and changed back."""
    chosen = hold_settings("torso")
    used, fresh = Simulation(chosen), Simulation(chosen)
    for key, value in (("rig", "table"), ("guided", "left"), ("g", 20.0), ("dt", 0.01), ("law", "unprotected"), ("task", "pose")):
        used.apply(changed(used.settings, key, value))
        play(used, wander(used, 20))
    used.apply(chosen)
    used.reset()
    targets = wander(fresh, 300)
    assert_array_equal(play(used, targets), play(fresh, targets))


def test_a_posture_given_to_reset_is_copied() -> None:
    """The arms start there, and the array given is not what they move in."""
    simulation = Simulation(hold_settings())
    start = np.array(overlapping_start("torso"))
    kept = start.copy()
    simulation.reset(start)
    assert_array_equal(simulation.positions, kept)
    play(simulation, wander(simulation, 50))
    assert_array_equal(start, kept)
    assert np.abs(simulation.positions - kept).max() > 0.01
    assert_array_equal(build_room("torso").start, Simulation(hold_settings()).positions)


# ---- changes on the way -------------------------------------------------------------------------------------------------------

SLIDERS: list[tuple[str, object]] = [
    ("dm", 0.25), ("n", 1.0), ("v", 0.9), ("beta", 30.0), ("k", 15.0), ("wmax", 0.9), ("dt", 0.02), ("g", 1.0), ("seed", 5),
    ("pairs", "single"), ("law", "unprotected"), ("ff", True), ("one_sided", True), ("task", "pose"), ("guided", "left"),
]  # fmt: skip


@pytest.mark.parametrize(("key", "value"), SLIDERS, ids=[key for key, _ in SLIDERS])
def test_a_slider_moves_no_arm(key: str, value: object) -> None:
    """Whatever is changed on the way, the arms are where they were at that instant, and go on from there without a leap."""
    simulation = Simulation(hold_settings("table"))
    play(simulation, wander(simulation, 300))
    q, time, count = simulation.positions.copy(), simulation.time, simulation.history.count
    simulation.apply(changed(simulation.settings, key, value))
    assert_array_equal(simulation.positions, q)
    assert (simulation.time, simulation.history.count) == (time, count)
    simulation.step(None)
    assert_array_equal(simulation.sample().positions, q)
    assert np.abs(simulation.positions - q).max() <= simulation.room.model.velocityLimit.max() * simulation.settings.dt
    assert simulation.history.count == count + 1


def test_a_slider_does_something() -> None:
    """Positive control: a larger d_m makes the same person push the other arm further away."""
    tables = []
    for dm in (0.10, 0.25):
        simulation = Simulation(hold_settings("table"))
        play(simulation, [HandTarget(avoiding_hand(simulation))] * 200)
        simulation.apply(changed(simulation.settings, "dm", dm))
        tables.append(play(simulation, [HandTarget(place_of(simulation))] * 600))
    assert column(tables[1], "d")[-1] > column(tables[0], "d")[-1] + 0.1


@pytest.mark.parametrize("rig", RIG_NAMES)
def test_changing_the_guided_arm_keeps_the_arms_and_swaps_the_roles(rig: RigName) -> None:
    """Nobody moves; the other hand's place is now where it is; from then on the new arm follows the target."""
    simulation = Simulation(hold_settings(rig))
    play(simulation, wander(simulation, 300))
    q = simulation.positions.copy()
    assert np.abs(simulation.velocities).max() > 0.0
    simulation.apply(changed(simulation.settings, "guided", "left"))
    assert_array_equal(simulation.positions, q)
    assert not simulation.velocities.any()
    assert (simulation.guided.name, simulation.avoiding.name) == ("left", "right")
    assert_allclose(place_of(simulation), avoiding_hand(simulation))
    target = HandTarget(guided_hand(simulation) + np.array([0.0, 0.05, 0.05]))
    play(simulation, [target] * 200)
    assert simulation.history.table()[300, SCALARS.index("e2")] == 0.0
    assert np.linalg.norm(guided_hand(simulation) - target.position) < 0.02
    assert np.abs((simulation.positions - q)[simulation.guided.joints]).max() > 0.01


def test_changing_the_rig_begins_anew() -> None:
    """Another rig is another room: everything from the start, exactly as in a fresh simulation there."""
    simulation, fresh = Simulation(hold_settings("torso")), Simulation(hold_settings("table"))
    play(simulation, wander(simulation, 100))
    simulation.apply(hold_settings("table"))
    assert (simulation.time, simulation.steps, simulation.history.count) == (0.0, 0, 0)
    assert_array_equal(simulation.positions, build_room("table").start)
    targets = wander(fresh, 200)
    assert_array_equal(play(simulation, targets), play(fresh, targets))


def test_a_time_step_changed_on_the_way_counts_from_then_on() -> None:
    """Time goes on by the new step."""
    simulation = Simulation(hold_settings(dt=0.005))
    play(simulation, [None] * 10)
    simulation.apply(changed(simulation.settings, "dt", 0.02))
    times = column(play(simulation, [None] * 10), "t")
    assert_allclose(np.diff(times), [0.005] * 10 + [0.02] * 9)


# ---- samples and history ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize("pairs", TREATMENTS)
def test_a_sample_before_any_step(rig: RigName, pairs: Treatment) -> None:
    """It measures what the first step will record, and makes no step."""
    simulation = Simulation(hold_settings(rig, pairs=pairs))
    first = simulation.sample()
    assert (simulation.steps, simulation.history.count, first.time) == (0, 0, 0.0)
    assert_array_equal(first.positions, simulation.room.start)
    assert not first.velocities.any()
    assert first.authority == Authority.FULL
    assert first.error == 0.0
    simulation.step(None)
    later = simulation.sample()
    assert simulation.history.count == 1
    for name in ("distance", "activation", "pair", "law_distance"):
        assert getattr(later, name) == getattr(first, name)
    first.positions[:] = 9.0
    assert np.abs(simulation.positions).max() < 9.0


def test_a_sample_is_the_newest_row() -> None:
    """Every number of a sample is the one in the table, and its arrays are its own."""
    simulation = Simulation(hold_settings("table"))
    table = play(simulation, wander(simulation, 200))
    sample = simulation.sample()
    names = ("time", "distance", "activation", "squared_error", "pull", "approach", "pair", "law_distance", "law_approach")
    columns = ("t", "d", "lambda", "e2", "u", "w", "pair", "law_d", "w_law")
    assert [getattr(sample, name) for name in names] == [column(table, name)[-1] for name in columns]
    assert_array_equal(sample.positions, simulation.history.positions(table)[-1])
    assert_array_equal(sample.velocities, simulation.history.velocities(table)[-1])
    sample.positions[:] = 9.0
    assert_array_equal(simulation.history.table(), table)


def test_each_row_holds_the_state_before_its_step() -> None:
    """q(k+1) = q(k) + q̇(k) dt in the table; d, e² and u are those of q(k)."""
    simulation = Simulation(hold_settings("table"))
    table = play(simulation, wander(simulation, 300))
    q, dq = simulation.history.positions(table), simulation.history.velocities(table)
    assert_allclose(np.diff(q, axis=0), dq[:-1] * simulation.settings.dt, atol=1e-15)
    assert_allclose(np.diff(column(table, "t")), simulation.settings.dt)
    for k in (0, 150, 299):
        assert true_distance(simulation, q[k]) == column(table, "d")[k]
        hand = simulation.kinematics.hand_pose(simulation.avoiding).translation
        assert float(np.sum((simulation.place - hand) ** 2)) == pytest.approx(column(table, "e2")[k], abs=1e-15)
    assert np.abs(dq).max() > 0.05


@given(st.integers(1, 12), st.integers(0, 40), st.integers(0, 15))
def test_the_ring_keeps_the_newest(capacity: int, count: int, newest: int) -> None:
    """Rows come back oldest first, the last `capacity` of them at most, and clear forgets them."""
    history = History(capacity, 2)
    for k in range(count):
        history.append((float(k), *[0.0] * (COLUMN["e2_b"] - 1)), np.full(2, float(k)), np.full(2, -float(k)))
    kept = list(range(count))[-capacity:]
    assert column(history.table(), "t").tolist() == kept
    assert column(history.table(newest), "t").tolist() == (kept[-newest:] if newest else [])
    assert history.count == count
    if count:
        assert history.last().time == count - 1
        assert_array_equal(history.positions(history.table())[-1], [count - 1.0] * 2)
        assert_array_equal(history.velocities(history.table())[-1], [1.0 - count] * 2)
    history.clear()
    assert len(history.table()) == 0
    with pytest.raises(IndexError, match="empty"):
        history.last()


def test_a_short_memory_changes_nothing_else() -> None:
    """A simulation that keeps 50 steps makes the same last 50 as one that keeps them all."""
    short, long = Simulation(hold_settings(), capacity=50), Simulation(hold_settings())
    targets = wander(long, 180)
    assert_array_equal(play(short, targets), play(long, targets)[-50:])
    assert short.history.count == 180


def test_a_table_is_a_copy() -> None:
    """Writing to a table handed out does not change what is kept."""
    simulation = Simulation(hold_settings())
    table = play(simulation, [None] * 5)
    kept = table.copy()
    table[:] = 7.0
    assert_array_equal(simulation.history.table(), kept)


# ---- limits -------------------------------------------------------------------------------------------------------------------


@settings(max_examples=25)
@given(
    st.sampled_from(RIG_NAMES), st.sampled_from(["left", "right"]), st.sampled_from(TREATMENTS), st.sampled_from(["position", "pose"]),
    st.integers(0, 10_000), st.sampled_from([0.00125, 0.005, 0.02]), st.floats(0.05, 1.0), st.floats(0.3, 10.0), st.booleans(),
)  # fmt: skip
def test_joints_stay_finite_and_inside_their_limits(
    rig: RigName, guided: ArmName, pairs: Treatment, task: str, seed: int, dt: float, speed: float, reach: float, anywhere: bool
) -> None:
    """Random targets, settings and starting postures, overlapping ones too: both arms keep stops and top speeds at every step."""
    random = np.random.default_rng(seed)
    chosen = hold_settings(rig, pairs=pairs, dt=dt)
    for key, value in (("guided", guided), ("task", task), ("wmax", speed), ("k", 20.0), ("g", 40.0), ("v", 1.0)):
        chosen = changed(chosen, key, value)
    simulation = Simulation(chosen)
    model = simulation.room.model
    if anywhere:
        simulation.reset(random.uniform(model.lowerPositionLimit, model.upperPositionLimit))
    place = guided_hand(simulation)
    for _ in range(6):
        target = HandTarget(place + random.uniform(-reach, reach, 3))
        for _ in range(20):
            simulation.step(target)
            assert inside_limits(simulation)
    table = simulation.history.table()
    assert np.isfinite(table[:, : COLUMN["e2_b"]]).all()
    assert np.isfinite(simulation.history.velocities(table)).all()
    assert np.abs(simulation.velocities[simulation.guided.joints]).max() > 0.0


@pytest.mark.parametrize("rig", RIG_NAMES)
def test_a_fast_person_meets_the_stops(rig: RigName) -> None:
    """Positive control: chased for long enough, some joint does come within a degree of its stop, and no further."""
    chosen = changed(changed(hold_settings(rig), "wmax", 1.0), "v", 1.0)
    simulation = Simulation(chosen)
    model, closest = simulation.room.model, np.inf
    random = np.random.default_rng(2)
    for _ in range(25):
        target = HandTarget(avoiding_hand(simulation) + random.uniform(-1.0, 1.0, 3))
        for _ in range(120):
            simulation.step(target)
            q = simulation.positions
            closest = min(closest, float(np.minimum(q - model.lowerPositionLimit, model.upperPositionLimit - q).min()))
    assert -1e-12 <= closest < np.radians(1.0)


# ---- out of authority ---------------------------------------------------------------------------------------------------------


def cornered(chosen: RunSettings, at_stops: bool, fits: Callable[[Array, Array], bool], tries: int = 3000) -> Simulation:
    """Return a simulation at a posture where the avoiding arm's row J_d and q satisfy a condition.

    Args:
        at_stops: draw the avoiding arm's joints at their stops instead of anywhere between.
        fits: of J_d (7,) and q (7,) of the avoiding arm.
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
    """J_d (7,) of the closest pair, of the avoiding arm at a sample."""
    simulation.kinematics.update(sample.positions)
    return simulation.detector.detect("single").row[simulation.avoiding.joints].copy()


def reach_of(simulation: Simulation, row: Array, q: Array) -> tuple[float, float]:
    """The largest retreat [m/s] that the avoiding arm's top speeds allow, and that its stops leave of it."""
    joints, model = simulation.avoiding.joints, simulation.room.model
    top, g = model.velocityLimit[joints], simulation.settings.limit_gain
    way = np.where(row > 0.0, model.upperPositionLimit[joints] - q, q - model.lowerPositionLimit[joints])
    return float(np.abs(row) @ top), float(np.abs(row) @ np.minimum(top, g * way))


def test_top_speed_is_told_as_the_reason() -> None:
    """A retreat of 1 m/s that all joints at top speed together cannot make: SPEED, the joint that counts most, and all there is."""
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
    assert float(row @ dq) == pytest.approx(float(np.abs(row) @ top), abs=1e-6)
    assert float(row @ dq) < 1.0


def test_a_stop_is_told_as_the_reason() -> None:
    """Joints at the stops that they would have to pass: STOP, a joint that is at its stop, and it does not move on."""
    probe = Simulation(FAST)

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


def short_lever(row: Array, q: Array) -> bool:
    """Whether a row is so short that damping leaves less than half of what the law asks."""
    del q
    square = float(row @ row)
    return 1e-4 < square < 0.8 * row_damping(square)


LEVER = with_law(hold_settings("table", pairs="single"), critical_distance=0.30, nominal_velocity=0.05)


def test_a_missing_lever_is_told_as_the_reason() -> None:
    """An approach that no joint can evade, J_d nearly 0: LEVERAGE; with a normal lever at the same d the reason is gone."""
    simulation = cornered(LEVER, False, short_lever)
    simulation.step(None)
    assert simulation.sample().authority == Authority.LEVERAGE
    assert simulation.sample().joint == -1
    assert summarise(simulation, simulation.history.table()).out_of_authority_s == simulation.settings.dt
    able = cornered(LEVER, False, lambda row, q: float(np.linalg.norm(row)) > 0.3 and float(np.abs(q).max()) < 1.5)
    able.step(None)
    assert able.sample().authority == Authority.FULL


def test_a_missing_lever_is_told_also_when_the_task_is_at_its_limits() -> None:
    """At λ = 1, a task at top speed that still pulls closer: whatever the box has to do with it, authority is not FULL."""
    simulation = cornered(LEVER, False, short_lever)
    simulation.apply(changed(simulation.settings, "k", 20.0))
    missed = 0
    for away in np.random.default_rng(1).uniform(-0.6, 0.6, (30, 3)):
        simulation.reset(simulation.positions.copy())
        place_of(simulation)[:] += away
        simulation.step(None)
        sample, joints = simulation.sample(), simulation.avoiding.joints
        simulation.positions[:] = sample.positions
        at_top = bool((np.abs(sample.velocities[joints]) >= simulation.room.model.velocityLimit[joints] - 1e-9).any())
        row = row_of(simulation, sample)
        if at_top and sample.activation == 1.0 and float(row @ sample.velocities[joints]) < 0.0:
            missed += 1
            assert sample.authority != Authority.FULL
    assert missed > 5


# ---- the headless summary -----------------------------------------------------------------------------------------------------


def test_the_summary_says_what_the_table_holds() -> None:
    """Every figure recomputed here from the table of a run with a person of one's own."""

    class Pusher:
        """Pushes towards the other hand, then lets go."""

        def target(self, time: float) -> HandTarget | None:
            """Return the target at a time [s]."""
            return HandTarget(np.array([0.0, 0.0, 1.3])) if time < 2.0 else None

    ticks: list[int] = []
    chosen = hold_settings("table")
    finished = run(chosen, 3.0, Pusher(), on_progress=ticks.append)
    table, summary = finished.table, finished.summary
    assert summary.steps == len(table) == 600 == sum(ticks)
    assert summary.d_min == column(table, "d").min()
    assert summary.e2_max == column(table, "e2").max() > 0.0
    assert summary.e2_end == column(table, "e2")[-1]
    assert summary.share_below == float((column(table, "d") < 0.15).mean())
    dq = finished.simulation.history.velocities(table)[:, :7]
    assert summary.dq_step_max == np.abs(np.diff(dq, axis=0)).max()
    assert summary.ddq_max == pytest.approx(summary.dq_step_max / chosen.dt)
    pairs, at_work = column(table, "pair").tolist(), (column(table, "lambda") >= FELT).tolist()
    switches = [i for i in range(1, len(pairs)) if pairs[i] != pairs[i - 1]]
    assert summary.pair_switches == len(switches)
    assert summary.pair_switches_felt == sum(at_work[i] or at_work[i - 1] for i in switches)
    assert summary.d_min_pair.startswith("left ") and " / right " in summary.d_min_pair


def test_switches_of_far_pairs_are_counted_apart() -> None:
    """The same run with λ that reaches far, and with one that is next to nothing there: only the law tells them apart."""
    table = run(hold_settings("table", pairs="single"), 6.0).table
    simulation = Simulation(hold_settings("table"), len(table))
    near, far = table.copy(), table.copy()
    near[:, COLUMN["lambda"]], far[:, COLUMN["lambda"]] = 1.0, FELT / 2.0
    far[0, COLUMN["lambda"]] = 1.0
    felt, not_felt = summarise(simulation, near), summarise(simulation, far)
    assert felt.pair_switches == felt.pair_switches_felt == not_felt.pair_switches > 2
    assert not_felt.pair_switches_felt == 0


def test_without_a_person_it_is_the_autopilot() -> None:
    """The default person is the autopilot of the settings' seed; a start posture given is where it begins."""
    chosen = hold_settings("torso", seed=4)
    autopilot = Autopilot(build_room("torso"), "right", 4)
    assert_array_equal(run(chosen, 1.0).table, run(chosen, 1.0, autopilot).table)
    start = np.array(overlapping_start("torso"))
    begun = run(chosen, 0.1, start=start)
    assert_array_equal(begun.simulation.history.positions(begun.table)[0], start)
