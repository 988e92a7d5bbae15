"""Phases of a lesson, the run of each step, and challenges: size of failures, counted attempts."""

from dataclasses import replace

import numpy as np
import pytest

from app.features.custom_law.trials import WHY, verdict_on
from app.features.lessons.attempts import StandIn, attempt_of
from app.features.lessons.bookmark import Phase
from app.features.lessons.labels import Contrast
from app.features.lessons.lesson import Start
from app.features.lessons.outcomes import reference
from app.features.lessons.reference_runs import begin_reference_run, person_of, simulated
from app.features.lessons.walkthrough import Walkthrough
from app.features.measures.room_places import RoomPlace, start_positions
from app.settings import PageSettings, Settings
from controllers.laws.situation import Situation
from scenes.roles import NO_TARGETS
from scenes.settings import LawSettings, RunSettings, changed
from scenes.simulation import Simulation
from scenes.targets import HandTarget
from tests.app.features.lessons.helpers import our_book, run_out, to_challenge
from tests.approved import Approve


def test_texts_appear_in_the_order_of_the_phases(walk: Walkthrough) -> None:
    def texts() -> tuple[str, ...]:
        return tuple(name for name, _ in walk.view().texts)

    # There is no run before an answer.
    assert walk.locked and walk.phase is Phase.PREDICT and not walk.view().can_next
    assert not walk.next() and not walk.choose(2) and not walk.choose(-1)
    seen = [texts()]
    assert walk.locked and walk.choose(1) and not walk.locked and walk.phase is Phase.DO
    run_out(walk)
    for _ in range(5):
        seen.append(texts())
        if not walk.next():
            break
    everything = ("goal", "predict", "do", "observe", "explain", "challenge")
    assert seen[:4] == [everything[:2], everything[:4], everything[:5], everything]
    assert walk.step.id == "second" and walk.phase is Phase.OBSERVE
    assert not walk.next() and not walk.view().can_next


def test_the_verdict_has_the_choice_the_outcome_and_the_reason(walk: Walkthrough) -> None:
    for answer, right in ((1, True), (0, False)):
        walk.reset()
        walk.choose(answer)
        assert walk.view().verdict is None
        run_out(walk)
        verdict, outcome = walk.view().verdict, walk.done.outcome
        assert verdict is not None and outcome is not None and verdict.right is right
        text = walk.step.measurements[0].text(outcome.values[0][0])
        assert text in verdict.reply and text in verdict.lines[0] and "n = 4" in verdict.lines[0]


def test_a_run_with_other_settings_does_not_answer_the_question(walk: Walkthrough) -> None:
    assert "mm" in dict(walk.view().texts)["predict"]
    walk.choose(0)
    settings = walk.setup.run
    simulation = Simulation(changed(settings, "n", 1.0))
    # The ball is at another place than in the question's run.
    simulation.reset(start_positions(simulation.room, Start(RoomPlace("goal", (0.0, 0.0, 1.0), 0.1))))
    for _ in range(100):
        simulation.step(None)
    outcome, asked = walk.observe(simulation), reference(walk.step, walk.step.setup)
    assert outcome == walk.done.outcome == replace(asked, unlike=(("n", 1.0),))
    assert asked.values[0][0] != pytest.approx(float(simulation.history.table()[:, 1].min()))
    verdict = walk.view().verdict
    assert verdict is not None and walk.step.measurements[0].text(asked.values[0][0]) in verdict.reply
    (line,) = [line for line in verdict.lines if "reference run" in line]
    assert "n = 1" in line and "did not get that far" not in line
    # A step without a question accepts any settings.
    walk.go("small", 1)
    simulation = Simulation(changed(walk.setup.run, "n", 1.0))
    for _ in range(100):
        simulation.step(None)
    outcome = walk.observe(simulation)
    assert (
        outcome.values[0][0] == pytest.approx(float(simulation.history.table()[:, 1].min()))
        and not outcome.reference
    )
    walk.next()
    (line,) = [line for line in walk.view().outcome if "n = 1" in line]
    assert "Reset" in line


def test_an_unfinished_run_decides_nothing(walk: Walkthrough) -> None:
    walk.choose(0)
    simulation = Simulation(walk.setup.run)
    for _ in range(50):
        simulation.step(None)
    assert not walk.finished(simulation)
    outcome = walk.observe(simulation)
    assert not outcome.complete and outcome.values[0][0] is not None
    assert walk.phase is Phase.DO and walk.done.outcome is None
    assert walk.next()
    assert walk.done.outcome is not None and walk.done.outcome.reference
    assert "reference" in " ".join(walk.view().outcome)


def test_a_prediction_can_be_changed_until_the_outcome_is_known(walk: Walkthrough) -> None:
    walk.choose(0)
    assert walk.choose(1) and walk.done.choice == 1
    assert walk.back() and walk.locked and walk.done.choice == 1 and walk.view().can_next
    assert walk.next() and walk.phase is Phase.DO and walk.done.choice == 1
    walk.back()
    assert walk.choose(0) and walk.choose(1) and walk.phase is Phase.DO
    run_out(walk)
    assert not walk.choose(0) and walk.done.choice == 1
    walk.back()
    assert walk.phase is Phase.DO and not walk.choose(0)
    assert not walk.back() and walk.phase is Phase.DO


def test_a_wrong_answer_offers_a_contrast_run(walk: Walkthrough) -> None:
    walk.choose(1)
    run_out(walk)
    assert not walk.view().why and not walk.show_why()
    walk.reset()
    walk.choose(0)
    assert not walk.show_why()
    run_out(walk)
    turn = walk.run_id
    assert walk.view().why and walk.show_why() and walk.run_id == turn + 1
    assert walk.setup.run.law.order == 6.0
    contrast = walk.view().contrast
    assert contrast == Contrast("See for yourself: n = 6", ("n",), "n = 6", "n = 2", ("n = 6", "n = 2"))
    run_out(walk)
    assert walk.done.why is not None and walk.view().why_outcome and walk.view().showing
    assert walk.next() and walk.view().contrast is None and walk.phase is Phase.OBSERVE
    assert walk.setup.run.law.order == 2.0


def do_much(walk: Walkthrough) -> None:
    """Answer the first step's question, see its contrast run, and try its challenge."""
    walk.choose(0)
    run_out(walk)
    walk.show_why()
    run_out(walk)
    to_challenge(walk)
    walk.attempt(simulated(walk.setup))


def test_back_and_next_keep_the_progress(walk: Walkthrough) -> None:
    do_much(walk)
    assert walk.next() and walk.step.id == "second"
    before = walk.done_in("small", "first")
    assert walk.back() and walk.phase is Phase.CHALLENGE
    while walk.back():
        pass
    assert walk.step.id == "first" and walk.phase is Phase.DO
    assert walk.done == before and walk.done.choice == 0 and walk.done.attempts == 1


def test_a_reset_clears_the_step_except_the_students_words(walk: Walkthrough) -> None:
    fresh = Walkthrough(walk.book).view()
    do_much(walk)
    walk.write("mine")
    assert [walk.hint() for _ in range(4)] == ["One.", "Two.", "Three.", None]
    assert walk.view().hints == ("One.", "Two.", "Three.")
    walk.reset()
    assert replace(walk.view(), done=fresh.done) == fresh and fresh.hints == ()
    # The student's words could not be restored, so they stay.
    assert replace(walk.done, words="").untouched and walk.done.words == "mine"


def test_the_run_has_the_lessons_settings_and_the_pages_look(walk: Walkthrough) -> None:
    before = Settings(RunSettings(scene="hold", gain=7.0), PageSettings(theme="dark"))
    after = walk.setup.settings(before)
    assert after.page.theme == "dark"
    assert after.run.scene == "ball" and after.run.law.order == 2.0 and after.run.gain == RunSettings().gain


def test_every_run_of_every_lesson_starts_with_live_values() -> None:
    walk = Walkthrough(our_book())
    for i, lesson in enumerate(walk.book.lessons):
        for j, step in enumerate(lesson.steps):
            walk.go(i, j)
            if step.question:
                walk.choose(0)
            simulation = Simulation(walk.setup.run, 100)
            begin_reference_run(simulation, walk.setup)
            assert all(value is None or np.isfinite(value) for _, value in walk.live(simulation))
            person = person_of(simulation, walk.setup, walk.kept)
            for _ in range(3):
                simulation.step(person.target(simulation.time))
            live = walk.live(simulation)
            assert len(live) == len(step.numbers) and all(m.text(value) for m, value in live)
            assert all(value is not None for _, value in live)


def test_a_failed_challenge_names_the_inequality_and_the_miss(walk: Walkthrough, approve: Approve) -> None:
    assert walk.attempt(simulated(walk.setup)) is None
    to_challenge(walk)
    simulation = simulated(walk.setup)
    failed = walk.attempt(simulation)
    assert failed is not None and not failed.passed and failed.failed == ("n",)
    approve("failed.txt", f"{failed.text}\n")
    assert not walk.done.passed and not walk.view().stale
    walk.run_again()
    assert walk.view().stale, "the verdict concerns the previous run"
    passed = walk.attempt(simulated(walk.step.trials[0].setup))
    assert passed is not None and passed.passed and walk.done.passed and not walk.view().stale
    walk.run_again()
    walk.attempt(simulation)
    assert walk.done.passed and walk.done.attempts == 3


def test_a_run_with_settings_changed_in_its_middle_does_not_count(walk: Walkthrough) -> None:
    to_challenge(walk)
    for when, counts in ((0, True), (10, False)):
        simulation = Simulation(walk.setup.run)
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


def test_a_run_counts_as_one_attempt_only_after_its_end(walk: Walkthrough) -> None:
    to_challenge(walk)
    simulation = Simulation(changed(walk.setup.run, "n", 7.0))
    walk.watch(simulation)
    early = walk.attempt(simulation)
    assert (
        early is not None
        and early.note == "Press Run first."
        and not early.passed
        and walk.done.attempts == 0
    )
    walk.watch(simulation)
    assert walk.view().done.last == early
    simulation.step(None)
    assert walk.watch(simulation) and walk.view().done.last is None, (
        "the message disappears when the run begins"
    )
    simulation.reset()
    assert not walk.watch(simulation)
    for steps, over in ((50, False), (50, True), (0, True), (0, True)):
        for _ in range(steps):
            simulation.step(None)
        walk.watch(simulation)
        attempt = walk.attempt(simulation)
        assert (
            attempt is not None
            and attempt.failed == ()
            and attempt.passed is over
            and ("2 s" in attempt.note) is not over
        )
    assert walk.done.passed and walk.done.attempts == 1
    simulation.reset()
    for _ in range(100):
        walk.watch(simulation)
        simulation.step(None)
    walk.attempt(simulation)
    assert walk.done.attempts == 2, "a reset run counts again"
    walk.run_again()
    walk.attempt(simulation)
    assert walk.done.attempts == 3, "*Run again* allows another attempt"


def test_each_forecast_is_compared_with_its_run() -> None:
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


def test_the_students_movement_is_kept_for_the_step_that_uses_it() -> None:
    walk = Walkthrough(our_book())
    walk.go("hold", 3)
    simulation = Simulation(walk.setup.run)
    script = person_of(simulation, walk.setup, walk.kept).target(2.0)
    assert isinstance(script, HandTarget)
    own = person_of(simulation, walk.setup)
    walk.go("hold", 2)
    assert walk.yours and person_of(simulation, walk.setup, walk.kept) is NO_TARGETS
    to_challenge(walk)
    attempt = walk.attempt(simulated(walk.step.trials[0].setup), person=own)
    assert attempt is not None and attempt.passed
    walk.go("hold", 3)
    assert person_of(simulation, walk.setup, walk.kept) is own


def textbook(s: Situation) -> np.ndarray:
    lam = 1.0 if s.distance <= 0.15 else (0.15 / s.distance) ** 6
    square = float(s.row @ s.row)
    return s.nominal + s.row * (lam * (0.3 + s.pull) / square) if square else s.nominal


def test_the_textbooks_law_fails_without_a_lever(approve: Approve) -> None:
    attempt = attempt_of(
        [verdict_on(StandIn(textbook), test) for test in ("gets out", "bounded where J_d is singular")]
    )
    assert attempt.failed == ("bounded where J_d is singular",)
    (judgement,) = [j for j in attempt.judgements if not j.passed]
    assert judgement.text.endswith(WHY[judgement.id])
    said, fails, _ = judgement.text.partition(" fails by ")
    assert fails
    approve("textbook.txt", f"{said}\n")


def test_attempts_with_a_custom_law_are_counted() -> None:
    walk = Walkthrough(our_book())
    walk.go("limits", 4)
    assert walk.attempt_custom_law(()) is None
    to_challenge(walk)
    assert walk.attempt(simulated(walk.setup)) is None
    law = StandIn(LawSettings(law="unprotected").made())
    verdicts = [verdict_on(law, test) for test in ("leaves the task alone", "gets out")]
    failed = walk.attempt_custom_law(verdicts)
    assert failed is not None and failed.failed == ("gets out",) and "fails by" in failed.text
    passed = walk.attempt_custom_law([verdict for verdict in verdicts if verdict.passed])
    assert passed is not None and walk.done.passed and walk.done.attempts == 2
