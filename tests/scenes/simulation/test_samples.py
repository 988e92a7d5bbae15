"""Samples, the history's ring and the headless summary, also with changes of the settings during a run."""

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
def test_the_levers_before_any_step_equal_those_of_the_first_step(avoid: AvoidChoice) -> None:
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


def test_an_arm_that_becomes_the_master_stops_following() -> None:
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


def test_a_sample_has_the_numbers_of_the_table_and_its_own_arrays() -> None:
    simulation = Simulation(hold_settings("table"))
    table = play(simulation, wander(simulation, 200))
    sample = simulation.sample()
    names = {
        "time": "t",
        "distance": "d",
        "activation": "lambda",
        "squared_error": "e2",
        "pull": "u",
        "approach": "w",
        "pair": "pair",
        "law_distance": "law_d",
        "law_approach": "w_law",
    }
    assert {name: getattr(sample, name) for name in names} == {
        name: column(table, of_table)[-1] for name, of_table in names.items()
    }
    assert_array_equal(sample.positions, simulation.history.positions(table)[-1])
    assert_array_equal(sample.velocities, simulation.history.velocities(table)[-1])
    sample.positions[:] = 9.0
    assert_array_equal(simulation.history.table(), table)


def test_rows_of_a_table_agree_with_each_other() -> None:
    """q(k+1) = q(k) + q̇(k) dt; d and e² belong to q(k)."""
    simulation = Simulation(hold_settings("table"))
    table = play(simulation, wander(simulation, 300))
    q, dq = simulation.history.positions(table), simulation.history.velocities(table)
    assert_allclose(np.diff(q, axis=0), dq[:-1] * simulation.settings.dt, atol=1e-15)
    assert_allclose(np.diff(column(table, "t")), simulation.settings.dt)
    for k in (0, 150, 299):
        assert true_distance(simulation, q[k]) == column(table, "d")[k]
        hand = simulation.kinematics.hand_pose(simulation.avoiding).translation
        error = float(np.sum((place_of(simulation) - hand) ** 2))
        assert error == pytest.approx(column(table, "e2")[k], abs=1e-15)
    assert np.abs(dq).max() > 0.05


def test_a_history_of_fifty_steps_has_the_last_fifty_of_a_whole_one() -> None:
    short, long = Simulation(hold_settings(), capacity=50), Simulation(hold_settings())
    targets = wander(long, 180)
    assert_array_equal(play(short, targets), play(long, targets)[-50:])
    assert short.history.count == 180


def test_changes_of_a_table_do_not_change_the_history() -> None:
    simulation = Simulation(hold_settings())
    table = play(simulation, [None] * 5)
    kept = table.copy()
    table[:] = 7.0
    assert_array_equal(simulation.history.table(), kept)


def test_a_reset_makes_a_new_history_and_the_old_one_is_still_readable() -> None:
    simulation = Simulation(hold_settings())
    kept = play(simulation, [None] * 5).copy()
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
def test_a_history_grows_to_its_capacity_and_missing_values_are_nan(capacity: int, count: int) -> None:
    history = History(capacity, 1)
    for k in range(count):
        history.append((float(k), *[0.0] * (COLUMN["e2_b"] - 1)), np.full(1, float(k)), np.zeros(1))
    kept = min(count, capacity)
    assert column(history.table(), "t").tolist() == list(range(count - kept, count))
    assert (
        np.isnan(history.desired(history.table())).all() and np.isnan(column(history.table(), "e2_b")).all()
    )


class Pusher:
    """A person who pushes towards the other hand for 2 s."""

    def target(self, time: float) -> HandTarget | None:
        return HandTarget(np.array([0.0, 0.0, 1.3])) if time < 2.0 else None


def test_a_summary_has_the_figures_of_the_table() -> None:
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


def test_a_switch_of_pairs_is_felt_only_with_an_active_law() -> None:
    """The same run with a large λ and with a negligible one."""
    table = run(hold_settings("table", pairs="single"), 6.0).table
    simulation = Simulation(hold_settings("table", pairs="single"), len(table))
    near, far = table.copy(), table.copy()
    near[:, COLUMN["lambda"]], far[:, COLUMN["lambda"]] = 1.0, FELT / 2.0
    far[0, COLUMN["lambda"]] = 1.0
    felt, not_felt = summarise(simulation, near), summarise(simulation, far)
    assert felt.pair_switches == felt.pair_switches_felt == not_felt.pair_switches > 2
    assert not_felt.pair_switches_felt == 0


def test_the_default_person_of_a_run_is_the_autopilot_of_its_seed() -> None:
    chosen = hold_settings("torso", seed=4)
    autopilot = Autopilot(build_room("torso"), "right", 4)
    assert_array_equal(run(chosen, 1.0).table, run(chosen, 1.0, autopilot).table)


def test_a_run_begins_at_a_given_posture() -> None:
    start = np.array(overlapping_start("torso"))
    begun = run(hold_settings("torso", seed=4), 0.1, start=start)
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


def test_a_larger_critical_distance_keeps_a_person_farther_away() -> None:
    tables = []
    for dm in (0.10, 0.25):
        simulation = Simulation(hold_settings("table"))
        play(simulation, [HandTarget(avoiding_hand(simulation))] * 200)
        simulation.apply(changed(simulation.settings, "dm", dm))
        tables.append(play(simulation, [HandTarget(place_of(simulation))] * 600))
    assert column(tables[1], "d")[-1] > column(tables[0], "d")[-1] + 0.1


def test_another_rig_begins_like_a_fresh_simulation() -> None:
    simulation, fresh = Simulation(hold_settings("torso")), Simulation(hold_settings("table"))
    play(simulation, wander(simulation, 100))
    simulation.apply(hold_settings("table"))
    assert (simulation.time, simulation.steps, simulation.history.count) == (0.0, 0, 0)
    assert_array_equal(simulation.positions, build_room("table").start)
    targets = wander(fresh, 200)
    assert_array_equal(play(simulation, targets), play(fresh, targets))


def test_time_continues_with_the_new_step() -> None:
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
