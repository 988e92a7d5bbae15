"""What the loop promises: the distance is kept, the smooth minimum is smooth, joints stay inside their limits, the same bits each time."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_array_equal

from controllers.choices import Treatment
from scenes.history import COLUMN
from scenes.room import build_room
from scenes.settings import ArmName, RigName, changed
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
    play,
    wander,
    with_law,
)
from tests.scenes.simulation.helpers import SEEDS, TREATMENTS, inside_limits


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
def test_what_the_law_and_the_minimum_are_for(rig: RigName, seed: int) -> None:
    # Positive control: the same inputs without avoidance drive the arms into each other, and the hand does not move at all.
    finished = hold_run(rig, seed, "single", "unprotected")
    assert finished.summary.d_min < 0.0 and finished.summary.e2_max < 1e-12
    guided = finished.simulation.guided.joints
    protected = hold_run(rig, seed, "single")
    history = finished.simulation.history
    assert_array_equal(history.positions(finished.table)[:, guided], history.positions(protected.table)[:, guided])
    # No joint of the avoiding arm is accelerated by more than 5 rad/s², though the closest pair switches.
    finished = hold_run(rig, seed, "soft")
    assert finished.summary.ddq_max <= 5.0 and finished.summary.ddq_max > 0.1


@pytest.mark.parametrize(("rig", "seed"), [("torso", 2), ("table", 3)])
def test_a_finer_step_makes_the_smooth_minimum_no_rougher_and_the_closest_pair_alone_jump(rig: RigName, seed: int) -> None:
    """Within 10 % at a quarter of dt; in a concave corner, q̇ jumps as much at half the step when the pair switches (control)."""
    coarse, fine, finest = (hold_run(rig, seed, "soft", dt=dt).summary for dt in (0.005, 0.0025, 0.00125))
    assert max(fine.ddq_max, finest.ddq_max) <= 1.1 * coarse.ddq_max
    rough, rougher = (hold_run(rig, seed, "single", dt=dt).summary for dt in (0.005, 0.0025))
    assert rough.dq_step_max > 0.05 and rougher.dq_step_max > 0.8 * rough.dq_step_max
    assert rougher.ddq_max > 1.6 * rough.ddq_max
    assert rougher.pair_switches > rough.pair_switches > 10
    assert fine.dq_step_max < 0.1 * rougher.dq_step_max


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize("pairs", TREATMENTS)
@pytest.mark.parametrize("guided", ["left", "right"])
def test_it_gets_out_of_contact_whichever_arm_has_to_move(rig: RigName, pairs: Treatment, guided: ArmName) -> None:
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
    rig: RigName, guided: ArmName, pairs: Treatment, task: str, seed: int, dt: float, speed: float, reach: float, anywhere: bool
) -> None:
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
def test_a_fast_person_meets_the_stops(rig: RigName) -> None:
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


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize("pairs", TREATMENTS)
def test_replays_resets_and_a_ghost_in_the_same_room(rig: RigName, pairs: Treatment) -> None:
    # After any run, in any mood of the guide, a reset simulation does bit for bit what a fresh one does.
    chosen = hold_settings(rig, pairs=pairs)
    used, fresh = Simulation(chosen), Simulation(chosen)
    targets = wander(fresh, 400)
    play(used, wander(used, 333, seed=9))
    used.reset()
    assert (used.time, used.steps, used.history.count) == (0.0, 0, 0)
    assert_array_equal(used.positions, fresh.positions)
    expected = play(fresh, targets)
    assert_array_equal(play(used, targets), expected)
    # A second simulation in the same room, stepped in between, changes no bit; without the law it goes elsewhere.
    watched, ghost = Simulation(chosen), Simulation(with_law(chosen, law="unprotected"))
    for target in targets:
        watched.step(target)
        ghost.step(target)
    assert_array_equal(watched.history.table(), expected)
    assert not np.array_equal(ghost.history.table(), expected)


def test_resets_start_afresh() -> None:
    # Also after the rig, the arm, and every number were changed and changed back.
    chosen = hold_settings("torso")
    used, fresh = Simulation(chosen), Simulation(chosen)
    for key, value in (("rig", "table"), ("guided", "left"), ("g", 20.0), ("dt", 0.01), ("law", "unprotected"), ("task", "pose")):
        used.apply(changed(used.settings, key, value))
        play(used, wander(used, 20))
    used.apply(chosen)
    used.reset()
    targets = wander(fresh, 300)
    assert_array_equal(play(used, targets), play(fresh, targets))
    # The arms start there, and the array given is not what they move in.
    simulation = Simulation(hold_settings())
    start = np.array(overlapping_start("torso"))
    kept = start.copy()
    simulation.reset(start)
    assert_array_equal(simulation.positions, kept)
    play(simulation, wander(simulation, 50))
    assert_array_equal(start, kept)
    assert np.abs(simulation.positions - kept).max() > 0.01
    assert_array_equal(build_room("torso").start, Simulation(hold_settings()).positions)
