"""The same inputs always give the same bits: replays, resets, and runs beside a ghost."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from controllers.proximity import Treatment
from scenes.room import build_room
from scenes.settings import RigName, changed
from scenes.simulation import Simulation
from tests.scenes.helpers import RIG_NAMES, hold_settings, overlapping_start, play, wander, with_law
from tests.scenes.simulation.helpers import TREATMENTS


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
