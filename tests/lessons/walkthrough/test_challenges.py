"""Challenges: which inequality fails and by how much, and what counts as an attempt."""

import numpy as np

from app.custom_law.trials import WHY
from app.lessons.law_challenge import StandIn, examine, stand_in
from app.lessons.reference_runs import person_of, simulated
from app.lessons.walkthrough import Walkthrough
from controllers.laws.situation import Situation
from scenes.roles import NoSource
from scenes.settings import changed
from scenes.simulation import Simulation
from scenes.targets import HandTarget
from tests.lessons.helpers import our_book, to_challenge


def test_a_failed_challenge_says_which_inequality_and_by_how_much(walk: Walkthrough) -> None:
    assert walk.attempt(simulated(walk.setup)) is None
    to_challenge(walk)
    simulation = simulated(walk.setup)
    failed = walk.attempt(simulation)
    assert failed is not None and not failed.passed and failed.failed == ("n",)
    assert "n: 2, but it must be at least 5. 3 is missing." in failed.text
    assert not walk.done.passed
    passed = walk.attempt(simulated(walk.step.trials[0].setup))
    assert passed is not None and passed.passed and walk.done.passed
    walk.attempt(simulation)
    assert walk.done.passed and walk.done.attempts == 3 and walk.view().passed


def test_settings_that_change_in_the_middle_of_a_run_do_not_count(walk: Walkthrough) -> None:
    to_challenge(walk)
    for when, counts in ((0, True), (10, False)):
        simulation = Simulation(walk.settings().run)
        walk.run_again()
        for i in range(100):
            if i == when:
                simulation.apply(changed(simulation.settings, "n", 7.0))
            walk.watch(simulation)
            simulation.step(None)
        walk.watch(simulation)
        attempt = walk.attempt(simulation)
        assert attempt is not None and attempt.passed is counts and bool(attempt.note) is not counts
    simulation.reset()
    for _ in range(101):
        walk.watch(simulation)
        simulation.step(None)
    attempt = walk.attempt(simulation)
    assert attempt is not None and attempt.passed


def test_a_run_that_is_not_over_does_not_count(walk: Walkthrough) -> None:
    to_challenge(walk)
    simulation = Simulation(changed(walk.settings().run, "n", 7.0))
    for _ in range(99):
        simulation.step(None)
    early = walk.attempt(simulation)
    assert early is not None and not early.passed and early.failed == () and "2 s" in early.note
    for _ in range(50):
        simulation.step(None)
    late = walk.attempt(simulation)
    assert late is not None and late.passed and not late.note


def test_forecasts_are_compared_with_runs_of_their_own() -> None:
    walk = Walkthrough(our_book())
    walk.go("strict-priority", 2)
    to_challenge(walk)
    assert len(walk.view().forecasts) == 3 and "v = 0.1" in walk.view().forecasts[0]
    simulation = simulated(walk.setup)
    empty = walk.attempt(simulation)
    assert empty is not None and len(empty.failed) == 3
    truth = [judgement.value for judgement in empty.judgements]
    assert all(value is not None for value in truth)
    for factor, passes in ((1.049, True), (0.951, True), (1.051, False)):
        attempt = walk.attempt(simulation, [value * factor for value in truth if value is not None])
        assert attempt is not None and attempt.passed is passes


def test_what_the_student_did_is_kept_for_the_step_that_asks_for_it() -> None:
    walk = Walkthrough(our_book())
    walk.go("hold", 3)
    simulation = Simulation(walk.settings().run)
    script = walk.target_source(simulation).target(2.0)
    assert isinstance(script, HandTarget)
    own = person_of(simulation, walk.setup)
    walk.go("hold", 2)
    assert walk.yours and isinstance(walk.target_source(simulation), NoSource)
    to_challenge(walk)
    attempt = walk.attempt(simulated(walk.step.trials[0].setup), person=own)
    assert attempt is not None and attempt.passed
    walk.go("hold", 3)
    assert walk.target_source(simulation) is own


def textbook(s: Situation) -> np.ndarray:
    lam = 1.0 if s.distance <= 0.15 else (0.15 / s.distance) ** 6
    square = float(s.row @ s.row)
    return s.nominal + s.row * (lam * (0.3 + s.pull) / square) if square else s.nominal


def test_the_textbooks_law_fails_where_there_is_no_lever() -> None:
    attempt = examine(StandIn(textbook), ("gets out", "bounded where J_d is singular"))
    assert attempt.failed == ("bounded where J_d is singular",)
    (judgement,) = [j for j in attempt.judgements if not j.passed]
    assert judgement.text.startswith("bounded where J_d is singular: |q̇| ≤ 1.92 rad/s")
    assert "fails by" in judgement.text and judgement.text.endswith(WHY[judgement.id])


def test_custom_law_attempts_are_noted() -> None:
    walk = Walkthrough(our_book())
    walk.go("limits", 4)
    assert walk.attempt_custom_law(()) is None
    to_challenge(walk)
    assert walk.attempt(simulated(walk.setup)) is None
    judgements = examine(stand_in("unprotected"), only=("leaves the task alone", "gets out")).judgements
    failed = walk.attempt_custom_law(judgements)
    assert failed is not None and failed.failed == ("gets out",) and "fails by" in failed.text
    passed = walk.attempt_custom_law([judgement for judgement in judgements if judgement.passed])
    assert passed is not None and walk.done.passed and walk.done.attempts == 2
