"""Parameters of measurements, how values are read, and rows that were forgotten."""

from typing import Any

import numpy as np
import pytest

from app.lessons.evidence import Evidence
from app.lessons.measures import checked_parameters, measure, shown_value
from controllers.errors import BadSetting
from scenes.simulation import Simulation
from tests.lessons.measures.runs import setup


@pytest.mark.parametrize(
    ("name", "given", "message"),
    [
        ("nothing", {}, "There is no measurement 'nothing'; choose from activation_formula"),
        ("distance_at", {}, "needs the parameter 'time'"),
        ("distance_at", {"time": "late"}, "is not a number"),
        ("distance_at", {"time": True}, "is not a number"),
        ("distance_at", {"time": float("nan")}, "is not a number"),
        ("distance_at", {"time": 1e9}, "too large"),
        ("distance_at", {"time": 1.0, "place": 2.0}, "has no parameter 'place'; choose from time"),
        ("setting", {"key": 4}, "is not a text"),
        ("smallest_distance", {"time": 1.0}, "it has none"),
    ],
)
def test_bad_parameters_are_named(name: str, given: dict[str, Any], message: str) -> None:
    with pytest.raises(BadSetting, match=message):
        checked_parameters(name, given)


def test_values_are_read_with_unit_and_true_signs() -> None:
    assert shown_value(-0.0123, "distance_margin", "mm", 1) == "−12.3 mm"
    assert shown_value(-0.00001, "distance_margin", "mm", 1) == "0.0 mm"
    assert shown_value(np.inf, "rest_now", "mm", 0) == "∞ mm"
    assert shown_value(None, "rest_now", "mm", 0) == "–"
    assert shown_value(np.pi / 2.0, "joint_error_now", "deg", 0) == "90°"
    assert shown_value(4.0, "rank_now", "", 0) == "4"
    assert shown_value(0.305, "speed_share", "%", 0) == "30%"


def test_a_row_that_was_forgotten_is_not_taken_for_another() -> None:
    simulation = Simulation(setup(scene="solo", path="circle", dt=0.02, k=2.0).run, 100)
    for _ in range(500):
        simulation.step(None)
    evidence = Evidence(simulation)
    assert not evidence.whole and evidence.rows == 100
    assert measure(evidence, "drift_per_lap") is None
    assert measure(evidence, "hand_error_at", (("time", 1.0),)) is None
    assert measure(evidence, "hand_error_at", (("time", 9.5),)) is not None
