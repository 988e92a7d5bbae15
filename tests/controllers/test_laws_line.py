"""Strict priority and the potential field: the laws that act along the row and are not the paper's."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from controllers.kinematics import null_space_projector
from controllers.laws.potential_field import PotentialField
from controllers.laws.smooth_priority import SmoothPriority
from controllers.laws.strict_priority import StrictPriority
from tests.controllers.test_laws_all import SEEDS, regular_situation

DISTANCES = st.floats(-0.2, 1.0)
FIELDS = st.builds(PotentialField, st.floats(0.1, 0.6), st.floats(1e-4, 0.05), st.floats(0.01, 0.1))


@given(SEEDS, st.floats(0.0, 1.0), st.floats(-0.2, 50.0))
def test_always_on_is_the_textbooks_eq_11(seed: int, v: float, distance: float) -> None:
    """q̇ = J_a^# v + N_a q̇_n at every distance, with J_a^# and N_a built as matrices by numpy."""
    situation = regular_situation(seed)._replace(distance=distance)
    J_a = situation.row[None, :]
    expected = np.linalg.pinv(J_a)[:, 0] * v + null_space_projector(J_a) @ situation.nominal
    assert_allclose(StrictPriority(0.15, v, switched=False)(situation), expected, atol=1e-11)


@given(SEEDS, st.floats(0.001, 0.5))
def test_switched_is_all_or_nothing(seed: int, way: float) -> None:
    """Always on up to d_m, the task alone beyond; 1 mm from d_m that is what the paper's law becomes as n → ∞."""
    situation = regular_situation(seed)
    always, switched = (StrictPriority(0.15, 0.3, switched=kind) for kind in (False, True))
    for distance in (0.15, 0.15 - way, 0.15 - 1e-6 * way, 0.15 + 1e-6 * way, 0.15 + way):
        near = situation._replace(distance=distance)
        assert_array_equal(switched(near), always(near) if distance <= 0.15 else near.nominal)
        if abs(distance - 0.15) == pytest.approx(way):
            assert_allclose(SmoothPriority(0.15, 1e4, 0.3)(near), switched(near), atol=1e-12)


@given(FIELDS, st.floats(0.02, 1.0))
def test_the_push_is_the_slope_of_the_potential(law: PotentialField, distance: float) -> None:
    """f = −dU/dd by finite differences, U = ½ η (1/d − 1/d₀)² below d₀ and 0 above; below the least distance f stays as it is."""

    def potential(d: float) -> float:
        return 0.5 * law.strength * (1.0 / min(d, law.influence_distance) - 1.0 / law.influence_distance) ** 2

    d, h = max(distance, law.least_distance), 1e-6
    if abs(d - law.influence_distance) < 2.0 * h:
        return
    slope = (potential(d + h) - potential(d - h)) / (2.0 * h)
    assert law.push(distance) == pytest.approx(-slope, rel=1e-4, abs=1e-7)


@given(FIELDS, DISTANCES)
def test_the_push_never_pulls(law: PotentialField, distance: float) -> None:
    assert law.push(distance) >= 0.0
    assert law.push(law.influence_distance) == law.push(math.inf) == 0.0
    assert law.push(distance) <= law.push(-0.1) == law.push(0.0) == law.push(law.least_distance)


def test_an_influence_inside_the_least_distance_is_none() -> None:
    for influence in (0.02, 0.05):
        law = PotentialField(influence, 0.005, 0.05)
        assert [law.push(d) for d in (-0.1, 0.0, 0.03, 0.2)] == [0.0] * 4 and law.activation(0.0) == 0.0


@given(SEEDS, FIELDS)
def test_the_push_does_not_look_at_the_task(seed: int, law: PotentialField) -> None:
    situation = regular_situation(seed)
    for nominal in (situation.nominal, 0.0 * situation.nominal):
        change = law(situation._replace(nominal=nominal)) - nominal
        assert_allclose(change, situation.row * law.push(situation.distance), atol=1e-9, rtol=1e-9)
