"""What the loop promises: the distance is kept, the smooth minimum is smooth, and what starts inside gets out.

In one file, as its tests look at the same runs.
"""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from controllers.proximity import Treatment
from scenes.settings import ArmName, RigName
from scenes.simulation import Simulation
from tests.scenes.helpers import RIG_NAMES, column, hold_run, hold_settings, overlapping_start, play
from tests.scenes.simulation.helpers import SEEDS, TREATMENTS


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("pairs", TREATMENTS)
def test_the_distance_is_kept(rig: RigName, seed: int, pairs: Treatment) -> None:
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
def test_what_the_law_and_the_minimum_are_for(rig: RigName, seed: int) -> None:
    # Positive control: the same inputs without avoidance drive the arms into each other, and the hand does not move at all.
    finished = hold_run(rig, seed, "single", "unprotected")
    assert finished.summary.d_min < 0.0
    assert finished.summary.e2_max < 1e-12
    guided = finished.simulation.guided.joints
    protected = hold_run(rig, seed, "single")
    history = finished.simulation.history
    assert_array_equal(history.positions(finished.table)[:, guided], history.positions(protected.table)[:, guided])
    # No joint of the avoiding arm is accelerated by more than 5 rad/s², though the closest pair switches.
    finished = hold_run(rig, seed, "soft")
    assert finished.summary.ddq_max <= 5.0
    assert finished.summary.ddq_max > 0.1


@pytest.mark.parametrize(("rig", "seed"), [("torso", 2), ("table", 3)])
def test_a_finer_step_makes_the_smooth_minimum_no_rougher_and_the_closest_pair_alone_jump(rig: RigName, seed: int) -> None:
    """Within 10 % at a quarter of dt; in a concave corner, q̇ jumps as much at half the step when the pair switches (control)."""
    coarse, fine, finest = (hold_run(rig, seed, "soft", dt=dt).summary for dt in (0.005, 0.0025, 0.00125))
    assert max(fine.ddq_max, finest.ddq_max) <= 1.1 * coarse.ddq_max
    rough, rougher = (hold_run(rig, seed, "single", dt=dt).summary for dt in (0.005, 0.0025))
    assert rough.dq_step_max > 0.05
    assert rougher.dq_step_max > 0.8 * rough.dq_step_max
    assert rougher.ddq_max > 1.6 * rough.ddq_max
    assert rougher.pair_switches > rough.pair_switches > 10
    assert fine.dq_step_max < 0.1 * rougher.dq_step_max


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize("pairs", TREATMENTS)
def test_it_gets_out_of_contact(rig: RigName, pairs: Treatment) -> None:
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
def test_it_gets_out_whichever_arm_has_to_move(rig: RigName, guided: ArmName) -> None:
    simulation = Simulation(replace(hold_settings(rig), guided=guided))
    simulation.reset(np.array(overlapping_start(rig)))
    still = simulation.positions[simulation.guided.joints].copy()
    assert column(play(simulation, [None] * 250), "d")[-1] > 0.1
    assert_array_equal(simulation.positions[simulation.guided.joints], still)
