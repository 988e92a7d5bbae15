"""The robot behind the velocity, in closed form: line (R) with dead time and lag, around its rest and when an obstacle starts at once."""

import math

import numpy as np
import pytest

from controllers import budget
from controllers.kinematics import Array
from scenes.actuation import Actuation, before_stops
from scenes.settings import HardwareSettings, RigName
from tests.scenes.helpers import RIG_NAMES
from tests.scenes.test_closed_forms import DM, Contact, V, contact_at

N, U = 20.0, 0.4
REST, TAU = budget.resting_distance(DM, N, V, U), budget.settling_time(DM, N, V, U)
NEAR = 1e-4
"""Start beside the rest [m]; near enough for the linear line."""


def late_run(contact: Contact, steps: int, dt: float, hardware: HardwareSettings, approach: float = 0.0) -> Array:
    """Return d (steps + 1,) while the left arm avoids through dead time and lag, and the right one comes with w."""
    path, actuation = [contact.measure()], Actuation(len(contact.q))
    velocities = np.zeros_like(contact.q)
    for step in range(steps):
        command = np.zeros_like(velocities)
        command[contact.left] = contact.avoiding(contact.left, path[-1], U, approach, 0.0)
        velocities = actuation.reached(hardware, command, velocities, step * dt, dt)
        contact.q[contact.left] += velocities[contact.left] * dt
        contact.q[contact.right] += contact.along(contact.right, -approach) * dt
        path.append(contact.measure())
    return np.array(path)


def swings(path: Array) -> tuple[float, float]:
    """Return the largest distance from the rest in the second and in the last fifth of a path [m]."""
    away, fifth = np.abs(path - REST), len(path) // 5
    return float(away[fifth : 2 * fifth].max()), float(away[-fifth:].max())


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize("late", [1, 4, 12])
def test_a_dead_time_overshoots_and_swings_exactly_where_the_closed_form_says(rig: RigName, late: int) -> None:
    calm, stable = budget.largest_share_of_step(late)
    for share, overshoots, grows in (
        (0.9 * calm, False, False),
        (1.3 * calm, True, False),
        (0.93 * stable, True, False),
        (1.07 * stable, True, True),
    ):
        dt = share * TAU
        hardware = HardwareSettings(dead_time=late * dt)
        assert budget.steps_late(hardware.dead_time, dt) == late
        path = late_run(contact_at(rig, REST + NEAR, N), round(25.0 * (late + 1)), dt, hardware)
        assert bool(path.min() < REST - 1e-3 * NEAR) is overshoots
        earlier, later = swings(path)
        assert (later > 1.2 * earlier) is grows
        assert (later < 0.8 * earlier) is not grows


def test_many_short_steps_have_the_limits_of_continuous_time() -> None:
    calm, stable = budget.largest_share_of_step(10_000)
    assert calm * 10_000 == pytest.approx(1.0 / math.e, rel=1e-3)
    assert stable * 10_000 == pytest.approx(0.5 * math.pi, rel=1e-3)
    assert budget.largest_share_of_step(0) == (1.0, pytest.approx(2.0))
    assert budget.largest_dead_time(TAU) == pytest.approx(0.5 * math.pi * TAU)
    assert budget.largest_dead_time_without_overshoot(TAU) == pytest.approx(TAU / math.e)
    # A lag of 1 µs is none, and a lag alone never makes it unstable.
    assert budget.largest_dead_time(TAU, 1e-6) == pytest.approx(budget.largest_dead_time(TAU), rel=1e-3)
    assert 0.0 < budget.largest_dead_time(TAU, 0.1) < budget.largest_dead_time(TAU, 0.01) < budget.largest_dead_time(TAU)
    assert budget.largest_dead_time(math.inf, 0.01) == math.inf


@pytest.mark.parametrize("lag", [0.2 * TAU, 2.0 * TAU])
def test_a_lag_takes_from_the_dead_time_that_is_allowed(lag: float) -> None:
    allowed = budget.largest_dead_time(TAU, lag)
    assert allowed < budget.largest_dead_time(TAU)
    for share, grows in ((0.85, False), (1.15, True)):
        late = 40
        dt = share * allowed / late
        path = late_run(contact_at("torso", REST + NEAR, N), 900, dt, HardwareSettings(dead_time=late * dt, lag=lag))
        earlier, later = swings(path)
        assert (later > 1.2 * earlier) is grows
        assert (later < 0.8 * earlier) is not grows


@pytest.mark.parametrize("rig", RIG_NAMES)
def test_a_sudden_start_costs_the_speed_times_the_dead_time(rig: RigName) -> None:
    dt, w, T = 0.001, 0.2, 0.05
    path = late_run(contact_at(rig, REST, N), round(2.0 * T / dt), dt, HardwareSettings(dead_time=T), approach=w)
    lost = REST - path[round(T / dt)]
    assert lost == pytest.approx(budget.surprise_loss(w, T), rel=0.01)
    # The ideal robot answers at once.
    ideal = late_run(contact_at(rig, REST, N), round(T / dt), dt, HardwareSettings(), approach=w)
    assert REST - ideal[-1] < 0.5 * lost
    assert ideal.min() > DM > path.min()


def test_a_lag_is_exact_for_a_constant_command() -> None:
    command, lag = np.array([1.0, -2.0]), 0.03
    for dt in (0.001, 0.005, 0.02):
        actuation, velocities = Actuation(2), np.zeros(2)
        steps = round(0.06 / dt)
        for step in range(steps):
            velocities = actuation.reached(HardwareSettings(lag=lag), command, velocities, step * dt, dt)
        assert velocities == pytest.approx(command * (1.0 - math.exp(-0.06 / lag)), rel=1e-12)


def test_a_stop_holds_a_lagging_joint() -> None:
    lower, upper = np.array([-1.0, -1.0, -1.0]), np.array([1.0, 1.0, 1.0])
    q = np.array([0.999, 0.0, -1.001])
    held = before_stops(np.array([0.5, 0.5, -0.5]), q, lower, upper, 0.01)
    assert held == pytest.approx([0.1, 0.5, 0.0])
    # A joint that is beyond its stop may come back.
    assert before_stops(np.array([0.5, 0.5, 0.5]), q, lower, upper, 0.01)[2] == 0.5
