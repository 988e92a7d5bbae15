"""Samples, the history's ring and the headless summary: what they say of a run."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from controllers.choices import Treatment
from controllers.limits import Authority
from scenes.autopilot import Autopilot
from scenes.headless import FELT, run, summarise
from scenes.history import COLUMN, History
from scenes.room import build_room
from scenes.settings import RigName
from scenes.simulation import Simulation
from scenes.targets import HandTarget
from tests.scenes.helpers import RIG_NAMES, column, hold_settings, overlapping_start, play, true_distance, wander
from tests.scenes.simulation.helpers import TREATMENTS


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


def test_samples_and_tables() -> None:
    # Every number of a sample is the one in the table, and its arrays are its own.
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
    # q(k+1) = q(k) + q̇(k) dt in the table; d, e² and u are those of q(k).
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
    history.clear()
    assert len(history.table()) == 0
    with pytest.raises(IndexError, match="empty"):
        history.last()


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
