"""The order of things in a lesson (goal, prediction, run, outcome, reason, and the ways back) and the run of each step."""

from dataclasses import replace

import numpy as np
import pytest

from app.lessons.contrast import Contrast
from app.lessons.lesson import LessonBook
from app.lessons.phases import Phase
from app.lessons.reference_runs import begin, simulated
from app.lessons.walkthrough import Walkthrough
from app.settings import PageSettings, Settings
from controllers.errors import BadSetting
from scenes.settings import RunSettings, changed
from scenes.simulation import Simulation
from tests.lessons.helpers import our_book, run_out, to_challenge


def test_goal_predict_do_observe_explain_challenge(walk: Walkthrough) -> None:
    def texts() -> tuple[str, ...]:
        return tuple(name for name, _ in walk.view().texts)

    # Nothing runs before an answer is chosen.
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
        assert walk.verdict is None
        run_out(walk)
        verdict, outcome = walk.verdict, walk.done.outcome
        assert verdict is not None and outcome is not None and verdict.right is right
        text = walk.step.measurements[0].text(outcome.values[0][0])
        assert text in verdict.reply and text in verdict.lines[0] and "n = 4" in verdict.lines[0]


def test_the_outcome_is_that_of_this_run(walk: Walkthrough) -> None:
    assert "mm" in dict(walk.view().texts)["predict"]
    walk.choose(0)
    settings = walk.settings().run
    simulation = Simulation(changed(settings, "n", 1.0))
    begin(simulation, walk.setup)
    for _ in range(100):
        simulation.step(None)
    outcome = walk.observe(simulation)
    assert outcome.values[0][0] == pytest.approx(float(simulation.history.table()[:, 1].min()))
    assert outcome.unlike == (("n", 1.0),)
    assert any("n = 1" in line and "Reset" in line for line in walk.view().outcome)


def test_an_unfinished_run_decides_nothing(walk: Walkthrough) -> None:
    walk.choose(0)
    simulation = Simulation(walk.settings().run)
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


def test_the_run_that_shows_why(walk: Walkthrough) -> None:
    walk.choose(1)
    run_out(walk)
    assert not walk.view().why and not walk.show_why()
    walk.reset()
    walk.choose(0)
    assert not walk.show_why()
    run_out(walk)
    turn = walk.run_id
    assert walk.view().why and walk.show_why() and walk.run_id == turn + 1
    assert walk.settings().run.law.order == 6.0
    contrast = walk.view().contrast
    assert contrast == Contrast("Here, too, you are wrong: n = 6", ("n",), "n = 6", "n = 2", ("n = 6", "n = 2"))
    run_out(walk)
    assert walk.done.why is not None and walk.view().why_outcome and walk.view().showing
    assert walk.next() and walk.view().contrast is None and walk.phase is Phase.OBSERVE
    assert walk.settings().run.law.order == 2.0


def test_back_and_forward_keep_what_was_done_and_reset_is_a_fresh_start(walk: Walkthrough) -> None:
    fresh = Walkthrough(walk.book).view()
    walk.choose(0)
    run_out(walk)
    walk.show_why()
    run_out(walk)
    to_challenge(walk)
    walk.attempt(simulated(walk.setup))
    assert walk.next() and walk.step.id == "second"
    before = walk.done_in("small", "first")
    assert walk.back() and walk.phase is Phase.CHALLENGE
    while walk.back():
        pass
    assert walk.step.id == "first" and walk.phase is Phase.DO
    assert walk.done == before and walk.done.choice == 0 and walk.done.attempts == 1
    walk.write("mine")
    assert [walk.hint() for _ in range(4)] == ["One.", "Two.", "Three.", None]
    assert walk.view().hints == ("One.", "Two.", "Three.") and not walk.view().more_hints
    walk.reset()
    assert walk.view() == fresh and fresh.hints == () and fresh.more_hints
    # But for the student's own words, which cannot be had again.
    assert replace(walk.done, words="").untouched and walk.done.words == "mine"


def test_the_run_has_the_lessons_settings_and_the_pages_own_look(walk: Walkthrough) -> None:
    before = Settings(RunSettings(scene="hold", gain=7.0), PageSettings(theme="dark"))
    after = walk.settings(before)
    assert after.page.theme == "dark"
    assert after.run.scene == "ball" and after.run.law.order == 2.0 and after.run.gain == RunSettings().gain


def test_every_run_of_every_lesson_can_be_begun_as_a_page_does_it() -> None:
    walk = Walkthrough(our_book())
    for i, lesson in enumerate(walk.book.lessons):
        for j, step in enumerate(lesson.steps):
            walk.go(i, j)
            if step.question:
                walk.choose(0)
            simulation = Simulation(walk.settings().run, 100)
            simulation.reset(walk.start(simulation))
            assert all(value is None or np.isfinite(value) for _, value in walk.live(simulation))
            person = walk.target_source(simulation)
            for _ in range(3):
                simulation.step(person.target(simulation.time))
            live = walk.live(simulation)
            assert len(live) == len(step.numbers) and all(m.text(value) for m, value in live)
            assert all(value is not None for _, value in live)


def test_a_fresh_run_is_asked_for_when_one_has_to_begin(walk: Walkthrough) -> None:
    turn = walk.run_id
    walk.choose(0)
    assert walk.run_id == turn + 1
    run_out(walk)
    assert walk.phase is Phase.OBSERVE and walk.run_id == turn + 1
    walk.next()
    assert walk.phase is Phase.EXPLAIN and walk.run_id == turn + 1
    walk.next()
    assert walk.phase is Phase.CHALLENGE and walk.run_id == turn + 2
    walk.next()
    walk.reset()
    assert walk.run_id == turn + 4


def test_going_to_a_step_that_is_not_there_is_refused(walk: Walkthrough) -> None:
    before = walk.view()
    for lesson, step in (("none", 0), (7, 0), (-1, 0), ("small", 2), ("small", -1)):
        with pytest.raises(BadSetting):
            walk.go(lesson, step)
    assert walk.view() == before
    with pytest.raises(BadSetting, match="no lesson"):
        Walkthrough(LessonBook((), ()))
