"""Lesson cases of the core's `test_true_words.py`."""

import numpy as np
import pytest

from app.features.measures.evidence import Evidence
from app.features.measures.quantities.quantity import measure
from app.features.measures.room_places import RoomPlace, Start, start_positions
from app.page.panels.contact_card import contact_numbers
from app.page.panels.distance_rate import budget_terms
from app.plots.time_series import COLUMNS, resting_now, signals
from app.session.frame import freeze
from app.session.session import Session
from app.settings import Settings
from controllers.choices import Treatment
from scenes.history import COLUMN
from scenes.laws import DEFAULT_LAW, LAWS
from scenes.settings import changed
from scenes.simulation import Simulation
from scenes.targets import HandTarget
from tests.scenes.helpers import place_of


def begin(simulation: Simulation) -> HandTarget | None:
    """Orange hand's target, or None for a ball; both are near enough that the silver hand must move away."""
    if simulation.room.ball is None:
        return HandTarget(place_of(simulation) + np.array([0.0, -0.2, 0.0]))
    simulation.reset(start_positions(simulation.room, Start(RoomPlace("goal", (0.0, 0.0, 1.0), 0.1))))
    return None


RESTING = [name for name, entry in LAWS.items() if entry.rests]


RESTS = [
    # Two pairs of bodies tie there: the closest pair changes all the time.
    ("hold", DEFAULT_LAW, "single", 0.0),
    *(("hold", law, pairs, rate) for law in RESTING for pairs in ("soft", "smooth") for rate in (0.0, 50.0)),
    *(("ball", law, "single", rate) for law in RESTING for rate in (0.0, 50.0)),
]


@pytest.mark.parametrize(("scene", "law", "treatment", "rate"), RESTS)
def test_an_arm_rests_at_the_shown_distance_in_every_treatment_of_pairs(
    scene: str, law: str, treatment: Treatment, rate: float
) -> None:
    settings = Settings()
    chosen = {"law": law, "pairs": treatment, "fps": rate, "autopilot": False, "dt": 0.01, "scene": scene}
    for key, value in chosen.items():
        settings = changed(settings, key, value)
    session = Session(settings)
    simulation = session.simulation
    target = begin(simulation)
    # The hand leaves the goal of the ball experiment after 8 s.
    for _ in range(790 if scene == "ball" else 1000):
        simulation.step(target)
    frame = freeze(session, 0.0)
    sample, run = frame.sample, settings.run
    table = simulation.history.table(60)
    assert np.ptp(table[:, COLUMN["d"]]) < 1e-3 and sample.lever == 1.0 and sample.authority == 0, (
        "the arm is at rest and could move"
    )
    assert sample.activation > 0.1, "the law holds the arm back against its task"
    assert resting_now(simulation, sample) == pytest.approx(sample.distance, abs=1e-3)
    # The card, the plot, and the lesson's measurement.
    d, law_d, rest, *_ = contact_numbers(
        frame, frame.contact, budget_terms(simulation, sample, frame.contact), 0
    )
    assert d is not None and law_d is not None and rest is not None
    assert abs(rest - d) <= 1 and d == round(1e3 * sample.distance)
    columns = signals(simulation, run, table)
    # Each of the alternating pairs has its d*.
    assert columns[:, COLUMNS["d*"]].mean() == pytest.approx(columns[:, COLUMNS["d"]].mean(), abs=1e-3)
    evidence = Evidence(simulation)
    assert measure(evidence, "rest_now") == pytest.approx(measure(evidence, "distance_now"), abs=1e-3)
    assert (sample.distance - sample.law_distance > 2e-3) == (treatment != "single"), (
        "d_law differs from d except for single pairs"
    )
