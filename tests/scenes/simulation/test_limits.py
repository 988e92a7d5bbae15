"""Joints stay finite and inside their limits, whatever a person does."""

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from controllers.proximity import Treatment
from scenes.history import COLUMN
from scenes.settings import ArmName, RigName, changed
from scenes.simulation import Simulation
from scenes.targets import HandTarget
from tests.scenes.helpers import RIG_NAMES, avoiding_hand, guided_hand, hold_settings
from tests.scenes.simulation.helpers import TREATMENTS, inside_limits


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
