"""Settings that change on the way: no slider moves an arm, and each counts from then on."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from scenes.history import SCALARS
from scenes.room import build_room
from scenes.settings import RigName, changed
from scenes.simulation import Simulation
from scenes.targets import HandTarget
from tests.scenes.helpers import RIG_NAMES, avoiding_hand, column, guided_hand, hold_settings, place_of, play, wander

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
    assert np.abs(simulation.positions - q).max() <= simulation.room.model.velocityLimit.max() * simulation.settings.dt
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
