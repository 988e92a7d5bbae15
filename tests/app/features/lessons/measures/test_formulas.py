"""Closed forms compared with runs; parameters, moments and displayed values of measurements."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.features.lessons.lesson import Measurement, Start, Step
from app.features.lessons.reference_runs import simulated
from app.features.measures.evidence import Evidence
from app.features.measures.quantities.contact_line import balance
from app.features.measures.quantities.joint_speeds import largest_zigzag
from app.features.measures.quantities.quantity import (
    QUANTITIES,
    At,
    measure,
    moment,
    read_parameters,
    shown_value,
)
from app.features.measures.room_places import RoomPlace
from controllers.errors import BadSetting
from scenes.history import COLUMN
from scenes.settings import LawSettings, RunSettings
from scenes.simulation import Simulation
from tests.app.features.lessons.helpers import our_book
from tests.app.features.lessons.measures.test_measurements import RUNS, looped_zigzag, setup
from tests.approved import Approve


@pytest.mark.parametrize("degrees", [20.0, 10.0, 5.0, 1.0])
def test_the_lever_of_an_elbow_is_its_upper_arm_times_the_sine(degrees: float) -> None:
    """|J_d| = L sin φ with L = 0.4 m, and λ v / |J_d| in the first step; a joint's top speed is 1.92 rad/s."""
    tilt = float(np.radians(degrees))
    run = replace(RUNS["short"], start=Start(RoomPlace("elbow", "upper_arm", 0.1, tilt)), seconds=0.3)
    evidence = Evidence(simulated(run))
    assert measure(evidence, "smallest_lever") == pytest.approx(0.4 * np.sin(tilt), rel=1e-6)
    assert measure(evidence, "textbook_speed") == pytest.approx(0.3 / (0.4 * np.sin(tilt)), rel=1e-6)
    assert (measure(evidence, "reached_speed") or 9.0) <= 1.93


@given(
    n=st.floats(1.0, 20.0),
    v=st.floats(0.01, 1.0),
    K=st.floats(0.1, 20.0),
    inside=st.floats(0.0, 0.6),
    d_m=st.floats(0.03, 0.3),
)
def test_balance_solves_its_equation(n: float, v: float, K: float, inside: float, d_m: float) -> None:
    d = balance(
        RunSettings(law=LawSettings(critical_distance=d_m, order=n, nominal_velocity=v), gain=K), inside
    )
    lam = (d_m / d) ** n
    assert lam * v == pytest.approx((1.0 - lam) * K * (d - inside), abs=1e-6)
    assert d >= max(d_m, inside) - 1e-9
    assert balance(RunSettings(gain=0.0), 0.1) == np.inf
    still = LawSettings(critical_distance=d_m, order=n, nominal_velocity=0.0)
    assert balance(RunSettings(law=still, gain=K), inside) == max(d_m, inside)


@given(values=st.lists(st.floats(-1.0, 1.0), max_size=40))
def test_zigzag_is_the_smallest_of_four_swings(values: list[float]) -> None:
    assert largest_zigzag(np.array(values))[0] == pytest.approx(looped_zigzag(np.array(values)), abs=1e-15)


BAD_PARAMETERS: tuple[tuple[str, dict[str, Any]], ...] = (
    ("distance_at", {}),
    ("distance_at", {"time": "late"}),
    ("distance_at", {"time": True}),
    ("distance_at", {"time": float("nan")}),
    ("distance_at", {"time": 1e9}),
    ("distance_at", {"time": 1.0, "place": 2.0}),
    ("setting", {"key": 4}),
    ("smallest_distance", {"time": 1.0}),
)


def test_bad_parameters_are_named(approve: Approve) -> None:
    said = ""
    for name, values in BAD_PARAMETERS:
        with pytest.raises(BadSetting) as found:
            read_parameters(f"measurement {name}", QUANTITIES[name].parameters, values)
        said += f"{found.value}\n"
    approve("parameters.txt", said)


def test_a_resting_distance_exists_only_for_laws_with_a_closed_form() -> None:
    """Smooth priority has a closed form; the switch, although it also comes to rest, does not."""
    for law, told in (("smooth_priority", True), ("strict_switched", False), ("unprotected", False)):
        run = RUNS["tail"].with_changes((("law", law),))
        assert (measure(Evidence(simulated(replace(run, seconds=0.1))), "rest_now") is not None) is told


def test_values_are_shown_with_unit_and_correct_sign() -> None:
    assert shown_value(-0.0123, "mm", 1) == "−12.3 mm"
    assert shown_value(-0.00001, "mm", 1) == "0.0 mm"
    assert shown_value(np.inf, "mm", 0) == "∞ mm"
    assert shown_value(None, "mm", 0) == "–"
    assert shown_value(np.pi / 2.0, "deg", 0) == "90°"
    assert shown_value(4.0, "", 0) == "4"
    assert shown_value(0.305, "%", 0) == "30%"


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [
        (0.000313, 3, "0.31 mm"),
        (0.001221, 3, "1.2 mm"),
        (0.0337, 1, "34 mm"),
        (0.424, 0, "424 mm"),
        (0.0, 1, "0.0 mm"),
        (-0.0546, 1, "−55 mm"),
        (2e-9, 3, "< 0.001 mm"),
        (1e-6, 3, "0.0010 mm"),
        (-2e-9, 3, "0.0000 mm"),
    ],
)
def test_a_measured_value_has_two_significant_digits(value: float, digits: int, text: str) -> None:
    assert Measurement("x", "hand_error_now", (), "mm", digits).text(value) == text


def test_counts_are_shown_as_whole_numbers() -> None:
    assert Measurement("x", "null_dimension", (), "", 0).text(4.0) == "4"


def test_a_discarded_row_is_not_replaced_by_another() -> None:
    simulation = Simulation(setup(scene="solo", path="circle", dt=0.02, k=2.0).run, 100)
    for _ in range(500):
        simulation.step(None)
    evidence = Evidence(simulation)
    assert not evidence.whole and evidence.rows == 100
    assert measure(evidence, "drift_per_lap") is None
    assert measure(evidence, "hand_error_at", (("time", 1.0),)) is None
    assert measure(evidence, "hand_error_at", (("time", 9.5),)) is not None


def step_of(lesson: str, step: str) -> Step:
    return next(one for one in our_book().lessons[our_book().index(lesson)].steps if one.id == step)


def test_a_moment_is_the_time_after_the_decisive_step() -> None:
    step = step_of("hold", "push")
    evidence = Evidence(simulated(step.setup), step.setup.seconds)
    row = int(evidence.column("d").argmin())
    assert moment(evidence, "smallest_distance") == pytest.approx(
        evidence.table[row, COLUMN["t"]] + evidence.settings.dt
    )
    assert moment(evidence, "distance_at", (("time", 1.5),)) == pytest.approx(1.5 + evidence.settings.dt)
    # A count over the whole run, and a time outside the run, have no moment.
    assert (
        moment(evidence, "pair_switches") is None
        and moment(evidence, "distance_at", (("time", 50.0),)) is None
    )


def test_the_row_of_a_measurement_contains_its_value() -> None:
    evidence = Evidence(simulated(step_of("master-slave", "copy").setup), 12.0)
    speeds = np.abs(evidence.velocities)
    names = ("reached_speed", "speed_share", "largest_joint_error", "largest_approach")
    found = {name: at.row for name in names if isinstance(at := QUANTITIES[name].function(evidence), At)}
    assert speeds[found["reached_speed"]].max() == measure(evidence, "reached_speed")
    assert (speeds / evidence.room.model.velocityLimit[evidence.arm.joints])[
        found["speed_share"]
    ].max() == measure(evidence, "speed_share")
    errors = np.linalg.norm(evidence.desired - evidence.positions[:, evidence.arm.joints], axis=1)
    assert errors[found["largest_joint_error"]] == measure(evidence, "largest_joint_error")
    assert evidence.column("w")[found["largest_approach"]] == measure(evidence, "largest_approach")
