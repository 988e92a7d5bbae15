"""The league's runs: the same persons at other speeds, a hidden half, the knob that keeps the distance."""

from dataclasses import replace

import numpy as np
import pytest

from app.features.league.league_runs import (
    CRITICAL_DISTANCE,
    FULL,
    NATURAL_SPEED,
    NO_KNOB,
    NOMINAL_VELOCITY,
    Event,
    Schedule,
    law_held,
)
from app.features.studies.law_knobs import MATCH
from scenes.headless import run
from scenes.history import COLUMN
from scenes.laws import NO_AVOIDANCE
from scenes.roles import paced
from scenes.simulation import Simulation
from scenes.targets import HandTarget

SHORT = Schedule(6.0, (0.5,), (2,))


def test_a_person_at_another_speed_takes_the_same_path() -> None:
    event, person = Event("hold", "ideal", "default"), SHORT.persons()[0]
    source = Simulation(event.settings(person), 1).source()
    fast = paced(Simulation(event.settings(person), 1).source(), 2.5)
    for time in (0.3, 1.0, 2.2):
        there, here = source.target(2.5 * time), fast.target(time)
        assert isinstance(there, HandTarget) and isinstance(here, HandTarget)
        assert np.array_equal(there.position, here.position)


def test_the_word_determines_the_hidden_half_with_equally_many_persons() -> None:
    first, again, other = (replace(FULL, word=word).persons() for word in ("pear", "pear", "plum"))
    assert first == again and [p for p in first if p.half == "public"] == FULL.persons()
    hidden, others = ([p.seed for p in persons if p.half == "hidden"] for persons in (first, other))
    assert (
        len(hidden) == len(FULL.persons())
        and set(hidden).isdisjoint(others)
        and set(hidden).isdisjoint(FULL.seeds)
    )


def test_a_law_with_its_own_settings() -> None:
    event, person = Event("hold", "delayed", "default"), SHORT.persons()[0]
    outcome = law_held("smooth_priority", SHORT, event)
    settings = event.settings(person)
    factor = person.speed / NATURAL_SPEED
    done = run(settings, SHORT.seconds / factor, paced(Simulation(settings, 1).source(), factor))
    (figures,) = outcome.runs
    assert (outcome.value, outcome.reached, outcome.problem) == (
        None,
        None,
        "",
    ) and outcome.step_us is not None
    summary = done.summary
    assert figures[3:] == (
        figures.lost,
        summary.d_min,
        summary.e2_max,
        summary.dq_step_max,
        summary.out_of_authority_s,
    )
    assert (figures.half, figures.number, figures.speed) == ("public", 1, 0.5)
    # A person faster than v brings d below d_m; that does not count as a loss of the law.
    table = done.table
    assert (
        table[:, COLUMN["w"]].max() > NOMINAL_VELOCITY
        and summary.d_min < CRITICAL_DISTANCE
        and figures.lost == 0.0
    )


def test_losses_of_an_unprotected_arm() -> None:
    slow = replace(SHORT, speeds=(0.2,))
    (figures,) = law_held(NO_AVOIDANCE, slow, Event("hold", "ideal", "default")).runs
    assert figures.d_min < 0.0 and figures.lost == pytest.approx(CRITICAL_DISTANCE - figures.d_min)


@pytest.mark.thorough
def test_at_equal_safety_the_public_persons_keep_the_distance_on_average() -> None:
    event = Event("hold", "ideal", "equal")
    schedule = replace(SHORT, speeds=(0.3, 0.5), word="pear")
    outcome = law_held("potential_field", schedule, event)
    public = [figures.d_min for figures in outcome.runs if figures.half == "public"]
    assert outcome.value is not None and outcome.reached == pytest.approx(np.mean(public), abs=1e-12)
    assert abs(np.mean(public) - CRITICAL_DISTANCE) <= MATCH and len(outcome.runs) == 4
    alone = law_held("potential_field", replace(schedule, word=""), event)
    assert alone.value == outcome.value and alone.runs == outcome.runs[:2]


def test_a_law_without_a_knob_or_unable_to_keep_the_distance() -> None:
    event = Event("hold", "ideal", "equal")
    assert law_held("strict_priority", SHORT, event).problem == NO_KNOB
    outcome = law_held("null_space_avoidance", SHORT, event)
    assert (outcome.value, outcome.runs) == (None, ()) and "no value of its knob" in outcome.problem
    assert outcome.reached is not None and abs(outcome.reached - CRITICAL_DISTANCE) > MATCH
