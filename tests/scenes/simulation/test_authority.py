"""Out of authority: top speed, a stop or a missing lever is the reason."""

from collections.abc import Callable

import numpy as np
import pytest

from controllers.kinematics import Array
from controllers.laws.situation import row_damping
from controllers.limits import Authority
from scenes.headless import summarise
from scenes.history import Sample
from scenes.settings import RunSettings, changed
from scenes.simulation import Simulation
from tests.scenes.helpers import hold_settings, place_of, with_law
from tests.scenes.simulation.helpers import inside_limits


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


def test_bounds_are_the_reason() -> None:
    # A retreat of 1 m/s that all joints at top speed together cannot make: SPEED, the joint that counts most, and all there is.
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

    # Joints at the stops that they would have to pass: STOP, a joint that is at its stop, and it does not move on.
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
    """Whether a row is so short that damping leaves less than half of what the law asks."""
    square = float(row @ row)
    return 1e-4 < square < 0.8 * row_damping(square)


LEVER = with_law(hold_settings("table", pairs="single"), critical_distance=0.30, nominal_velocity=0.05)


def test_a_missing_lever_is_the_reason() -> None:
    # An approach that no joint can evade, J_d nearly 0: LEVERAGE; with a normal lever at the same d the reason is gone.
    simulation = cornered(LEVER, False, short_lever)
    simulation.step(None)
    assert simulation.sample().authority == Authority.LEVERAGE
    assert simulation.sample().joint == -1
    assert summarise(simulation, simulation.history.table()).out_of_authority_s == simulation.settings.dt
    able = cornered(LEVER, False, lambda row, q: float(np.linalg.norm(row)) > 0.3 and float(np.abs(q).max()) < 1.5)
    able.step(None)
    assert able.sample().authority == Authority.FULL
    # At λ = 1, a task at top speed that still pulls closer: whatever the box has to do with it, authority is not FULL.
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
