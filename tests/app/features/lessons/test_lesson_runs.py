"""Runs of a lesson, without a page: begin, measurement and contrast."""

import pytest
from numpy.testing import assert_array_equal

from app.features.lessons.bookmark import Phase
from app.features.lessons.reference_runs import simulated
from app.features.lessons.session import lesson_actions as do
from app.plots.pair_strips import pairs_html
from app.plots.time_series import RollingSeries
from app.session.frame import freeze
from scenes.history import COLUMN
from scenes.rerun import rerun
from tests.app.features.lessons.student import BOOK, Student
from tests.approved import Approve


def test_a_run_is_locked_until_an_answer_and_invalid_actions_are_ignored() -> None:
    one = Student()
    session, run = one.session, one.run
    nonsense = (do.GoTo(99, 0), do.GoTo(0, 99), do.Choose(-1), do.Choose(99))
    for action in (do.Press("run"), do.Press("next"), do.Press("why"), do.Press("check"), *nonsense):
        run.act(action)
        one.frame()
        assert (
            session.paused and session.simulation.steps == 0 and run.open and run.walk.phase is Phase.PREDICT
        ), action
    session.control.toggle_pause()
    run.decide()
    assert session.paused
    run.act(do.Choose(0))
    assert run.walk.phase is Phase.DO
    run.act(do.Press("run"))
    session.advance(0.1)
    assert session.simulation.steps > 0


def test_at_the_lever_the_laws_run_is_hidden_until_the_end_and_repeatable() -> None:
    one = Student(BOOK.index("lambda"), 0)
    session, run = one.session, one.run
    seen = lambda: (session.traced[1] is not None, freeze(session, 0.0).ghost is not None)  # noqa: E731
    assert run.walk.step.at_lever and run.walk.phase is Phase.DO and session.paused
    run.act(do.Press("run"))
    for lever in (0.0, 0.8, 0.35, 1.0, 0.1):
        session.change("lever", lever)
        end = session.simulation.time + 3.0
        one.frames_until(lambda end=end: session.simulation.time >= end)
        assert seen() == (False, False)
    run.act(do.Press("next"))
    one.run_out()
    outcome = run.walk.done.outcome
    assert run.walk.phase is Phase.OBSERVE and outcome is not None and outcome.unlike == ()
    one.frame(0.0)
    assert seen() == (True, True) and session.ghost is not None
    own, law = (run.history.table() for run in (session.simulation, session.ghost))
    assert own[-1, COLUMN["lambda"]] == 0.1 and len(set(own[:, COLUMN["lambda"]])) == 5
    lost = tuple(max(0.1 - float(table[:, COLUMN["d"]].min()), 0.0) for table in (own, law))
    assert outcome.values[0] == lost and lost[0] > lost[1] == 0.0, (
        "the law keeps the distance that the student loses"
    )
    recorded = session.inputs.window(60.0)
    assert recorded is not None and recorded.steps == 6000
    assert_array_equal(rerun(recorded).table, own)
    run.leave()
    assert seen() == (False, False) and not session.ghost_hidden


def test_the_outcome_is_of_the_students_run_and_why_starts_a_contrast(approve: Approve) -> None:
    one = Student()
    run = one.run
    run.act(do.Choose(1))
    one.finish()
    verdict, outcome = run.walk.view().verdict, run.walk.done.outcome
    assert (
        run.walk.phase is Phase.OBSERVE and verdict is not None and not verdict.right and one.session.paused
    )
    assert outcome is not None and not outcome.reference
    run.act(do.Press("why"))
    assert run.walk.view().showing and one.session.simulation.steps == 0
    contrast = run.walk.view().contrast
    assert contrast is not None and contrast.keys == ("task",)
    approve(
        "contrast.txt", "".join(f"{one}\n" for one in (contrast.headline, contrast.asked, *contrast.names))
    )
    assert not one.session.paused, "the contrast run starts without a second click"
    one.run_out()
    assert run.walk.view().why_outcome
    other, asked = one.session.ghost, run.walk.step.setup
    assert (
        other is not None
        and other.settings == asked.run
        and other.time == pytest.approx(one.session.simulation.time)
    )
    assert_array_equal(
        other.history.table()[:, COLUMN["t"]], one.session.simulation.history.table()[:, COLUMN["t"]]
    )
    alone, count = simulated(asked).history, simulated(asked).steps
    assert_array_equal(
        other.history.table()[:count], alone.table(), "the ghost is the step's run with the step's inputs"
    )
    run.act(do.Press("next"))
    assert not run.walk.view().showing and one.session.ghost is None
    # The question's run is repeated at once, to its end, so that the plots show it.
    while not one.session.paused:
        one.frame(0.0)
    assert run.walk.phase is Phase.OBSERVE and run.walk.finished(one.session.simulation)
    assert_array_equal(one.session.simulation.history.table()[:count], alone.table())


def test_the_plot_and_the_outcome_count_the_same_changes() -> None:
    one = Student(9, 3)
    session, run = one.session, one.run
    run.act(do.Choose(2))
    run.act(do.Press("run"))
    # The run's duration is not a multiple of this frame time.
    one.frames_until(lambda: session.simulation.steps > 0 and session.paused, 0.047)
    assert session.simulation.time == pytest.approx(run.walk.setup.seconds, abs=1e-6)
    run.runner.further.result(60.0)
    run.decide()
    assert run.walk.done.outcome is not None
    (measured,) = run.walk.done.outcome.known(run.walk.step)["switches"]
    series = RollingSeries()
    series.feed(session.simulation)
    assert measured is not None and f"{measured:.0f} changes among" in pairs_html(session.simulation, series)
    run.leave()
    session.control.halt.go_on()
    session.advance(0.1)
    assert session.simulation.steps > 0 and session.control.frame_ends_at == 0.0


@pytest.mark.parametrize("halted", [False, True])
def test_a_skipped_run_is_still_measured_unless_it_is_halted(halted: bool) -> None:
    one = Student()
    session, run = one.session, one.run
    run.act(do.Choose(1))
    run.runner.further.result(60.0)
    if halted:
        session.control.halt.set("teacher")
    run.act(do.Press("next"))
    assert (run.walk.phase is Phase.OBSERVE) == halted
    while run.walk.phase is Phase.DO:
        before = session.simulation.steps
        one.frame(0.0)
        assert session.simulation.steps > before, "a skipped run advances without wall time"
    outcome = run.walk.done.outcome
    assert (
        run.walk.phase is Phase.OBSERVE
        and outcome is not None
        and outcome.complete
        and outcome.reference == halted
    )
    assert halted or (session.paused and run.walk.finished(session.simulation))
