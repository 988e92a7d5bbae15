"""Samples, the history's ring and the headless summary: what they say of a run, whose settings may change on the way."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from controllers.choices import Treatment
from controllers.limits import Authority
from scenes.headless import FELT, run, summarise
from scenes.history import COLUMN, SCALARS, History
from scenes.room import build_room
from scenes.settings import AvoidChoice, RigName, changed
from scenes.simulation import Simulation
from scenes.targets import HandTarget
from scenes.two_arms import Autopilot
from tests.scenes.helpers import (
    RIG_NAMES,
    TREATMENTS,
    avoiding_hand,
    column,
    guided_hand,
    hold_settings,
    overlapping_start,
    place_of,
    play,
    scene_settings,
    true_distance,
    wander,
)


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize("pairs", TREATMENTS)
def test_a_sample_before_any_step(rig: RigName, pairs: Treatment) -> None:
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


@pytest.mark.parametrize("avoid", ["free", "guided", "both"])
def test_the_levers_before_any_step_are_those_of_the_first_one(avoid: AvoidChoice) -> None:
    simulation = Simulation(scene_settings("master_slave", avoid=avoid))
    first = simulation.sample()
    simulation.step(None)
    later = simulation.sample()
    assert first.lever == later.lever > 0.0
    if avoid == "both":
        assert (
            first.second is not None
            and later.second is not None
            and first.second.lever == later.second.lever > 0.0
        )


def test_an_arm_that_leads_from_now_on_follows_no_more() -> None:
    simulation = Simulation(scene_settings("master_slave"))
    play(simulation, [None] * 5)
    assert not np.isnan(simulation.sample().desired[simulation.avoiding.joints]).any()
    simulation.apply(changed(simulation.settings, "guided", simulation.avoiding.name))
    simulation.step(None)
    desired = simulation.sample().desired
    assert (
        np.isnan(desired[simulation.guided.joints]).all()
        and not np.isnan(desired[simulation.avoiding.joints]).any()
    )


def test_samples_and_tables() -> None:
    # Every number of a sample is the one in the table, and its arrays are its own.
    simulation = Simulation(hold_settings("table"))
    table = play(simulation, wander(simulation, 200))
    sample = simulation.sample()
    names = (
        "time",
        "distance",
        "activation",
        "squared_error",
        "pull",
        "approach",
        "pair",
        "law_distance",
        "law_approach",
    )
    columns = ("t", "d", "lambda", "e2", "u", "w", "pair", "law_d", "w_law")
    assert [getattr(sample, name) for name in names] == [column(table, name)[-1] for name in columns]
    assert_array_equal(sample.positions, simulation.history.positions(table)[-1])
    assert_array_equal(sample.velocities, simulation.history.velocities(table)[-1])
    sample.positions[:] = 9.0
    assert_array_equal(simulation.history.table(), table)
    # q(k+1) = q(k) + q̇(k) dt in the table; d, e² and u are those of q(k).
    simulation = Simulation(hold_settings("table"))
    table = play(simulation, wander(simulation, 300))
    q, dq = simulation.history.positions(table), simulation.history.velocities(table)
    assert_allclose(np.diff(q, axis=0), dq[:-1] * simulation.settings.dt, atol=1e-15)
    assert_allclose(np.diff(column(table, "t")), simulation.settings.dt)
    for k in (0, 150, 299):
        assert true_distance(simulation, q[k]) == column(table, "d")[k]
        hand = simulation.kinematics.hand_pose(simulation.avoiding).translation
        assert float(np.sum((place_of(simulation) - hand) ** 2)) == pytest.approx(
            column(table, "e2")[k], abs=1e-15
        )
    assert np.abs(dq).max() > 0.05
    # A simulation that keeps 50 steps makes the same last 50 as one that keeps them all.
    short, long = Simulation(hold_settings(), capacity=50), Simulation(hold_settings())
    targets = wander(long, 180)
    assert_array_equal(play(short, targets), play(long, targets)[-50:])
    assert short.history.count == 180
    # Writing to a table handed out does not change what is kept.
    simulation = Simulation(hold_settings())
    table = play(simulation, [None] * 5)
    kept = table.copy()
    table[:] = 7.0
    assert_array_equal(simulation.history.table(), kept)
    # Another run has another history; the old one can still be read.
    before = simulation.history
    simulation.reset()
    assert simulation.history is not before and simulation.history.count == 0
    assert_array_equal(before.table(), kept)


@given(st.integers(1, 12), st.integers(0, 40), st.integers(0, 15))
def test_the_ring_keeps_the_newest(capacity: int, count: int, newest: int) -> None:
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
    else:
        with pytest.raises(IndexError, match="empty"):
            history.last()


@pytest.mark.parametrize(
    ("capacity", "count"), [(700, 699), (700, 701), (700, 2_000), (256, 600), (300, 256)]
)
def test_its_room_grows_up_to_its_capacity_and_what_is_not_given_is_nan(capacity: int, count: int) -> None:
    history = History(capacity, 1)
    for k in range(count):
        history.append((float(k), *[0.0] * (COLUMN["e2_b"] - 1)), np.full(1, float(k)), np.zeros(1))
    kept = min(count, capacity)
    assert column(history.table(), "t").tolist() == list(range(count - kept, count))
    assert (
        np.isnan(history.desired(history.table())).all() and np.isnan(column(history.table(), "e2_b")).all()
    )


def test_summaries() -> None:
    # Every figure recomputed here from the table of a run with a person who pushes towards the other hand, then lets go.
    class Pusher:
        def target(self, time: float) -> HandTarget | None:
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
    pairs = column(table, "pair").tolist()
    switches = [i for i in range(1, len(pairs)) if pairs[i] != pairs[i - 1]]
    assert summary.pair_switches == len(switches)
    assert summary.pair_switches_felt == 0
    assert summary.d_min_pair.startswith("left ") and " / right " in summary.d_min_pair
    # The same run with λ that reaches far, and with one that is next to nothing there: only the law tells them apart.
    table = run(hold_settings("table", pairs="single"), 6.0).table
    simulation = Simulation(hold_settings("table", pairs="single"), len(table))
    near, far = table.copy(), table.copy()
    near[:, COLUMN["lambda"]], far[:, COLUMN["lambda"]] = 1.0, FELT / 2.0
    far[0, COLUMN["lambda"]] = 1.0
    felt, not_felt = summarise(simulation, near), summarise(simulation, far)
    assert felt.pair_switches == felt.pair_switches_felt == not_felt.pair_switches > 2
    assert not_felt.pair_switches_felt == 0
    # The default person is the autopilot of the settings' seed; a start posture given is where it begins.
    chosen = hold_settings("torso", seed=4)
    autopilot = Autopilot(build_room("torso"), "right", 4)
    assert_array_equal(run(chosen, 1.0).table, run(chosen, 1.0, autopilot).table)
    start = np.array(overlapping_start("torso"))
    begun = run(chosen, 0.1, start=start)
    assert_array_equal(begun.simulation.history.positions(begun.table)[0], start)


SLIDERS: list[tuple[str, object]] = [
    ("dm", 0.25), ("n", 1.0), ("v", 0.9), ("beta", 30.0), ("k", 15.0), ("wmax", 0.9), ("dt", 0.02), ("g", 1.0), ("seed", 5),
    ("pairs", "single"), ("law", "unprotected"), ("ff", True), ("one_sided", True), ("task", "pose"), ("guided", "left"),
]  # fmt: skip


@pytest.mark.parametrize(("key", "value"), SLIDERS, ids=[key for key, _ in SLIDERS])
def test_a_slider_moves_no_arm(key: str, value: object) -> None:
    simulation = Simulation(hold_settings("table"))
    play(simulation, wander(simulation, 300))
    q, time, count = simulation.positions.copy(), simulation.time, simulation.history.count
    simulation.apply(changed(simulation.settings, key, value))
    assert_array_equal(simulation.positions, q)
    assert (simulation.time, simulation.history.count) == (time, count)
    simulation.step(None)
    assert_array_equal(simulation.sample().positions, q)
    assert (
        np.abs(simulation.positions - q).max()
        <= simulation.room.model.velocityLimit.max() * simulation.settings.dt
    )
    assert simulation.history.count == count + 1


def test_changes_on_the_way() -> None:
    # Positive control: a larger d_m makes the same person push the other arm further away.
    tables = []
    for dm in (0.10, 0.25):
        simulation = Simulation(hold_settings("table"))
        play(simulation, [HandTarget(avoiding_hand(simulation))] * 200)
        simulation.apply(changed(simulation.settings, "dm", dm))
        tables.append(play(simulation, [HandTarget(place_of(simulation))] * 600))
    assert column(tables[1], "d")[-1] > column(tables[0], "d")[-1] + 0.1
    # Another rig is another room: everything from the start, exactly as in a fresh simulation there.
    simulation, fresh = Simulation(hold_settings("torso")), Simulation(hold_settings("table"))
    play(simulation, wander(simulation, 100))
    simulation.apply(hold_settings("table"))
    assert (simulation.time, simulation.steps, simulation.history.count) == (0.0, 0, 0)
    assert_array_equal(simulation.positions, build_room("table").start)
    targets = wander(fresh, 200)
    assert_array_equal(play(simulation, targets), play(fresh, targets))
    # Time goes on by the new step.
    simulation = Simulation(hold_settings(dt=0.005))
    play(simulation, [None] * 10)
    simulation.apply(changed(simulation.settings, "dt", 0.02))
    times = column(play(simulation, [None] * 10), "t")
    assert_allclose(np.diff(times), [0.005] * 10 + [0.02] * 9)


@pytest.mark.parametrize("rig", RIG_NAMES)
def test_changing_the_guided_arm_keeps_the_arms_and_swaps_the_roles(rig: RigName) -> None:
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
