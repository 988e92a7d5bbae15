"""Closed forms of the law for every first task: rate of h, resting value, largest stable step."""

import numpy as np
import pytest

from controllers.budget import distance_rate, largest_step, resting_distance, settling_time
from controllers.kinematics import Array
from tests.controllers.first_tasks.helpers import NAMES, ORDER, PosedTask, posed, postures, regular

EXACT = 1e-9
MOVED = ("a wall that moves and turns", "several at once", "the other arm")
"""Tasks with a moving part: no posture is at rest."""

STILL = [name for name in NAMES if name not in MOVED]


def chosen(of: PosedTask, low: float, high: float, count: int, seed: int = 3) -> list[Array]:
    """Regular postures with h between `low` and `high` times h_m."""
    found: list[Array] = []
    critical = of.task.critical_value
    for q in postures(of, 20_000, seed):
        if low * critical <= of.value(q) <= high * critical and regular(of, q):
            found.append(q)
            if len(found) == count:
                return found
    raise AssertionError(f"only {len(found)} such postures")


@pytest.mark.parametrize("name", NAMES)
def test_the_rate_is_that_of_the_closed_form(name: str) -> None:
    """By J_a q̇, and by fourth-order differences of h along the motion."""
    of, task = posed(name), posed(name).task
    random = np.random.default_rng(4)
    for q in [*chosen(of, 0.3, 1.0, 6), *chosen(of, 1.0, 2.5, 12)]:
        of.at(q)
        margin, nominal = of.task.margin(), random.uniform(-1.0, 1.0, len(q))
        dq, u = of.stage(nominal), -float(margin.row @ nominal)
        lam = of.stage.law.activation(margin.value)
        wanted = distance_rate(lam, task.nominal_rate, u, margin.approach)
        assert float(margin.row @ dq) - margin.approach == pytest.approx(wanted, abs=EXACT)
        # Motion that does not change h stays as the task asks.
        across = (dq - nominal) - margin.row * (
            float(margin.row @ (dq - nominal)) / float(margin.row @ margin.row)
        )
        assert float(np.abs(across).max()) < EXACT
        t = 2e-6
        h = {k: of.value_after(q, dq, k * t) for k in (-2, -1, 1, 2)}
        rate = (8.0 * (h[1] - h[-1]) - (h[2] - h[-2])) / (12.0 * t)
        assert rate == pytest.approx(wanted, abs=EXACT)


@pytest.mark.parametrize("name", NAMES)
def test_at_the_resting_value_nothing_changes(name: str) -> None:
    """With the pull u = (λ v − w)/(1 − λ), h of the posture is the resting value h*."""
    of = posed(name)
    v, critical = of.task.nominal_rate, of.task.critical_value
    rested = 0
    for q in chosen(of, 1.05, 2.0, 15):
        of.at(q)
        margin = of.task.margin()
        lam, w = of.stage.law.activation(margin.value), margin.approach
        u = (lam * v - w) / (1.0 - lam)
        if u + w <= 0.0 or w > v:
            continue
        rested += 1
        assert resting_distance(critical, ORDER, v, u, w) == pytest.approx(margin.value, rel=EXACT)
        assert float(margin.row @ of.stage(of.pulled(u))) - w == pytest.approx(0.0, abs=EXACT)
    assert rested >= 3


def advanced(of: PosedTask, q: Array, u: float, dt: float, steps: int) -> Array:
    for _ in range(steps):
        of.at(q)
        q = q + dt * of.stage(of.pulled(u))
    return q


def rested(of: PosedTask) -> tuple[Array, float, float]:
    """Posture at rest under a constant pull, its h, and the pull."""
    v, critical = of.task.nominal_rate, of.task.critical_value
    u = 0.4 * v
    rest = resting_distance(critical, ORDER, v, u)
    for q in chosen(of, 1.05 * rest / critical, 1.15 * rest / critical, 8):
        q = advanced(of, q, u, 0.4 * settling_time(critical, ORDER, v, u), 60)
        if abs(of.value(q) - rest) < 1e-3 * rest and regular(of, q):
            return q, rest, u
    raise AssertionError("no posture comes to rest with a regular row")


@pytest.mark.parametrize("name", STILL)
def test_under_a_constant_pull_it_rests_at_the_closed_form(name: str) -> None:
    of = posed(name)
    q, rest, _ = rested(of)
    assert of.value(q) == pytest.approx(rest, abs=EXACT)


@pytest.mark.parametrize("name", STILL)
def test_twice_the_settling_time_is_the_largest_stable_step(name: str) -> None:
    of = posed(name)
    q, rest, u = rested(of)
    limit = 2.0 * settling_time(of.task.critical_value, ORDER, of.task.nominal_rate, u)
    of.at(q)
    row = of.task.margin().row
    aside = row * (1e-5 * rest / float(row @ row))
    ends = [of.value(advanced(of, q + side * aside, u, limit, 1)) for side in (1.0, -1.0)]
    multiplier = (ends[0] - ends[1]) / (of.value(q + aside) - of.value(q - aside))
    assert multiplier == pytest.approx(-1.0, abs=1e-6)
    begun = abs(of.value(q + aside) - rest)
    assert abs(of.value(advanced(of, q + aside, u, 0.95 * limit, 60)) - rest) < 0.1 * begun
    assert abs(of.value(advanced(of, q + aside, u, 1.05 * limit, 60)) - rest) > 5.0 * begun


@pytest.mark.parametrize("name", NAMES)
def test_at_the_threshold_the_slope_of_the_rate_gives_the_largest_step(name: str) -> None:
    """There λ is steepest: dt = 2 h_m/[n (v + u)] times the slope of ḣ is −2."""
    of = posed(name)
    v, critical, u = of.task.nominal_rate, of.task.critical_value, 0.3
    ahead = 1e-7 * critical
    slopes = [(of.stage.law.line_rate(critical + way, u, 0.0, 1.0) - v) / way for way in (ahead, 2.0 * ahead)]
    slope = 2.0 * slopes[0] - slopes[1]
    assert largest_step(critical, ORDER, v, u) * slope == pytest.approx(-2.0, abs=1e-6)
