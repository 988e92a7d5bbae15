"""The lessons of a session without a page: choices, runs, verdicts, challenges, and that nothing is stuck or lost."""

import contextlib
import math
import random
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from app.features.lessons.bookmark import Phase
from app.features.lessons.panel.elbow_marks import reaches
from app.features.lessons.panel.lesson_html import attempt_html, duel_html, learned_html
from app.features.lessons.progress import Try
from app.features.lessons.reference_runs import person_of, simulated
from app.features.lessons.session import lesson_actions as do
from app.features.lessons.session.lesson_session import LessonSession
from app.plots.pair_strips import pairs_html
from app.plots.time_series import RollingSeries
from app.session.frame import freeze
from app.session.session import Session
from app.settings import Settings
from controllers.errors import BadSetting
from scenes.history import COLUMN
from scenes.rerun import rerun
from scenes.roles import NO_TARGETS
from scenes.run_text import run_of_text, run_text
from scenes.settings import changed, specs, values
from scenes.targets import BallTarget, HandTarget
from tests.app.features.lessons.helpers import SMALL, book_of, our_book, to_challenge

BOOK = our_book()


class Student:
    """A session without a page, in a lesson."""

    def __init__(self, lesson: int = 0, step: int = 0, settings: Settings | None = None) -> None:
        self.session = Session(settings or Settings())
        self.run = LessonSession(self.session, BOOK)
        self.run.enter(lesson, step)

    def frame(self, elapsed: float = 0.05) -> None:
        self.session.advance(elapsed)
        self.run.decide()
        assert np.isfinite(self.session.simulation.positions).all()

    def frames_until(self, true: Callable[[], object], elapsed: float = 0.05) -> None:
        assert any(self.frame(elapsed) or true() for _ in range(4000)), "the run does not end"

    def finish(self) -> None:
        self.run.act(do.Press("run"))
        self.run_out()

    def run_out(self) -> None:
        self.run.runner.further.result(60.0)
        session, run = self.session, self.run
        self.frames_until(
            lambda: (
                session.paused
                and not run.computing
                and (run.runner.further.done() or session.simulation.steps == 0)
            )
        )
        self.run.decide()

    def to_challenge(self) -> None:
        """Go on to the step's challenge, and skip what can be skipped."""
        while self.run.walk.phase is not Phase.CHALLENGE:
            self.run.act(do.Press("next"))
            self.frame(0.0)

    def swing(self) -> None:
        """Swing the elbow as a drag would, mark to mark, until the present run is long enough."""
        setup = next(trial.setup for trial in self.run.walk.step.trials if not trial.fails)
        person = person_of(self.session.simulation, setup)
        while self.session.simulation.time < setup.seconds:
            self.session.hand.hold(person.target(self.session.simulation.time))
            self.frame(0.02)


def test_a_run_is_locked_until_an_answer_is_chosen_and_nonsense_does_no_harm() -> None:
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


def test_at_the_lever_the_law_plays_the_same_attack_unseen_until_the_end_and_all_of_it_can_be_made_again() -> (
    None
):
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
    assert outcome.values[0] == lost and lost[0] > lost[1] == 0.0, "the law keeps what this hand does not"
    recorded = session.inputs.window(60.0)
    assert recorded is not None and recorded.steps == 6000
    assert_array_equal(rerun(recorded).table, own)
    run.leave()
    assert seen() == (False, False) and not session.ghost_hidden


def test_the_outcome_is_measured_in_this_run_and_a_wrong_choice_gets_its_own() -> None:
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
    assert contrast is not None and contrast.headline == "Here you would be right: task set to “Hold pose”"
    assert (
        contrast.keys == ("task",)
        and contrast.asked == "task set to “Hold position”"
        and contrast.names == ("Hold pose", "Hold position")
    )
    assert not one.session.paused, "it runs without a second click"
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
        other.history.table()[:count], alone.table(), "the step's own run, with its own inputs"
    )
    run.act(do.Press("next"))
    assert not run.walk.view().showing and one.session.ghost is None
    # The question's run is made again at once, to its end, so that it stands in the plots.
    while not one.session.paused:
        one.frame(0.0)
    assert run.walk.phase is Phase.OBSERVE and run.walk.finished(one.session.simulation)
    assert_array_equal(one.session.simulation.history.table()[:count], alone.table())


def test_the_plot_counts_the_changes_that_the_outcome_counts() -> None:
    one = Student(9, 3)
    session, run = one.session, one.run
    run.act(do.Choose(2))
    run.act(do.Press("run"))
    # Frames that do not come out even at the end of the run.
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
def test_a_run_that_is_skipped_is_still_measured_where_it_can_go_on(halted: bool) -> None:
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
        assert session.simulation.steps > before, "it hurries, whatever the clock on the wall says"
    outcome = run.walk.done.outcome
    assert (
        run.walk.phase is Phase.OBSERVE
        and outcome is not None
        and outcome.complete
        and outcome.reference == halted
    )
    assert halted or (session.paused and run.walk.finished(session.simulation))


def test_leaving_gives_the_visitors_own_settings_back() -> None:
    before = changed(changed(Settings(), "dm", 0.11), "autopilot", False)
    one = Student(settings=before)
    session, run = one.session, one.run
    for lesson in range(len(BOOK.lessons)):
        run.enter(lesson)
        one.frame()
        assert values(session.settings)["scene"] == BOOK.lessons[lesson].steps[0].setup.run.scene
    session.change("theme", "dark")
    run.act(do.Press("leave"))
    assert session.settings == changed(before, "theme", "dark") and not session.paused and not run.open
    assert session.target() is None


def test_reset_is_a_fresh_start_and_another_experiment_begins_the_run_again() -> None:
    one = Student()
    session, run = one.session, one.run
    fresh = run.walk.to_json(), values(session.settings)
    run.act(do.Choose(2))
    session.change("k", 9.0)
    run.act(do.Press("reset"))
    assert (run.walk.to_json(), values(session.settings)) == fresh
    run.act(do.Press("back"))
    assert run.walk.phase is Phase.PREDICT
    run.act(do.Choose(2))
    session.change("scene", "hold")
    run.decide()
    assert session.settings.run.scene == "solo" and session.notices
    session.change("autopilot", False)
    run.decide()
    assert session.settings.page.autopilot


def test_a_challenge_says_what_failed_and_is_tried_again_with_the_students_own_settings() -> None:
    one = Student(0, 2)
    session, run = one.session, one.run
    assert reaches(run.walk.step) == (0.015, 0.015) and reaches(BOOK.lessons[0].steps[0]) == (), (
        "how near a mark is touched"
    )
    one.to_challenge()
    assert run.walk.yours and not run.hands_off and not session.paused
    run.act(do.Press("check"))
    assert "Press Run first." in attempt_html(run.walk.view())
    shown = run.version
    one.frame()
    assert run.version > shown and attempt_html(run.walk.view()) == "", (
        "the run that was asked for takes the request away"
    )
    for _ in range(40):
        one.frame()
    run.act(do.Press("check"))
    attempt = run.walk.done.last
    assert attempt is not None and not attempt.passed and attempt.failed
    assert any("must be" in j.text for j in attempt.judgements)
    run.act(do.Press("hint"))
    assert len(run.walk.view().hints) == 1
    session.change("k", 5.0)
    session.change("dt", 0.005)
    one.frame()
    run.act(do.Press("check"))
    attempt = run.walk.done.last
    assert attempt is not None and not attempt.passed and attempt.note, (
        "settings changed in the middle of the run"
    )
    run.act(do.Press("again"))
    assert session.simulation.steps == 0 and session.settings.run.gain == 5.0 and not session.paused
    one.swing()
    run.act(do.Press("check"))
    assert run.walk.done.passed, run.walk.done.last
    run.act(do.Press("reset"))
    run.act(do.Press("next"))
    assert session.settings.run.gain == run.walk.setup.run.gain != 5.0


def test_a_forecast_is_said_in_the_unit_in_which_it_is_asked(tmp_path: Path) -> None:
    asked = """[[challenge.forecast]]
id = "near"
name = "smallest_distance"
unit = "mm"
settings = { n = 6.0 }

[[attempt]]
name = "right"
forecasts = ["d"]
fails = ["near"]
"""
    criterion = SMALL[SMALL.index("[[challenge.criterion]]") : SMALL.index("```\n\n### Goal")]
    book = book_of(tmp_path, SMALL.replace(criterion, asked))
    assert not book.problems
    run = LessonSession(Session(Settings()), book)
    run.enter(0, 0)
    to_challenge(run.walk)
    here = run.walk.lesson.id, run.walk.step.id
    # What was typed in another step arrives there, however late.
    run.act(do.SayNumber(here[0], "another", 0, 7.0))
    assert run.said == []
    run.act(do.SayNumber(*here, 0, 1.0))
    run.runner.further.result(60.0)
    run.act(do.Press("check"))
    said = run.walk.done.last
    assert (
        said is not None
        and said.judgements[0].value is not None
        and "you said 1.0 mm" in said.judgements[0].text
    )
    run.act(do.SayNumber(*here, 0, 1000.0 * said.judgements[0].value))
    run.act(do.Press("check"))
    assert run.walk.done.passed


def push(one: Student, fast: float, then: float | None = None) -> None:
    """Take the hand and push it at the other one for a second, and count that. `then`: top speed from the middle on, if another."""
    session, run = one.session, one.run
    session.change("wmax", fast)
    run.act(do.Press("again"))
    pose = session.simulation.kinematics.hand_pose(session.hand.arm)
    place, turn = pose.translation.copy(), pose.rotation.copy()
    while session.simulation.time < 1.0:
        place[0] -= 0.05 * fast
        session.hand.hold(HandTarget(place.copy(), turn))
        one.frame()
        if then is not None and session.simulation.time > 0.5:
            session.change("wmax", then)
    run.act(do.Press("check"))


@pytest.mark.usefixtures("fast_machine")
def test_of_five_pushes_the_nearest_is_kept_and_is_in_its_link_to_the_last_bit() -> None:
    one = Student(BOOK.index("hold"), 2)
    session, run = one.session, one.run
    session.hand.hold(HandTarget(place := np.array([0.4, 0.01, 1.2]), None))
    assert session.held is not None and session.held[0] is place, "outside a duel a hand is where it is held"
    one.to_challenge()
    # A hand that is left alone costs no push, and a run that waits begins again.
    run.act(do.Press("check"))
    assert session.notices.pop()[0] == "Push first" and not run.walk.done.tries and run.walk.nearest is None
    before = run.walk.run_watch.run
    one.frames_until(lambda: run.walk.run_watch.run > before, 1.0)
    assert not run.over and not session.paused and not run.walk.done.tries
    speeds = (0.15, 0.25, 0.2, 0.1, 0.15, 0.4)
    tables: list[np.ndarray] = []
    for number, fast in enumerate(speeds):
        push(one, fast)
        assert run.over and session.paused and len(run.walk.done.tries) == min(number + 1, 5)
        tables.append(session.simulation.history.table())
        run.act(do.Press("check"))
        assert len(run.walk.done.tries) == min(number + 1, 5), "a push counts once"
        run.act(do.Press("run"))
        assert not run.over and session.simulation.steps == 0 and session.settings.run.hand_speed == fast
    tries, nearest, table = run.walk.done.tries, run.walk.nearest, tables[1]
    assert [one.setting for one in tries] == list(speeds[:5]) and min(
        tries, key=lambda one: one.measured
    ) is tries[1]
    assert nearest is not None and tables[5][:, COLUMN["d"]].min() < table[:, COLUMN["d"]].min(), (
        "the sixth does not count"
    )
    again = run_of_text(run_text(nearest))
    assert_array_equal(rerun(again).table, table)
    margin = float(table[:, COLUMN["d"]].min()) - 0.15
    assert tries[1].measured == margin
    said = attempt_html(run.walk.view()).replace("\u00a0", " ")
    assert f"You came to {1000 * margin:.1f} mm above dₘ." in said and said.count("mm above dₘ") == 6
    assert "broke through by 3.2\u00a0mm" in duel_html(
        replace(run.walk.view(), tries=(Try(0.4, -0.0032, True),))
    )
    # It outlives the process.
    saved = run.saved_lesson()
    assert saved is not None
    other = LessonSession(Session(Settings()), BOOK)
    other.resume(saved, reopen=True)
    assert other.walk.done.tries == tries and other.walk.nearest is nearest
    # Five new ones.
    run.act(do.Press("reset"))
    assert not run.walk.done.tries and run.walk.nearest is None
    one.to_challenge()
    push(one, 0.1)
    assert len(run.walk.done.tries) == 1 and run.walk.nearest is not nearest
    # A push under two settings does not count, and a duel counts no attempts beside its pushes.
    push(one, 0.1, 0.2)
    said = attempt_html(run.walk.view())
    assert len(run.walk.done.tries) == 1 and "Push 1 of 5" in said and "Press Next push." in said
    assert run.walk.done.attempts == 2 and "Attempt" not in said and "Reset, then" not in said
    # By another law, or with a smaller v, nothing counts.
    session.change("v", 0.1)
    push(one, 0.25)
    assert len(run.walk.done.tries) == 1 and run.over
    # A push that goes on is over after 10 s.
    session.change("v", 0.3)
    run.act(do.Press("run"))
    session.hand.hold(HandTarget(np.array([0.3, 0.0, 1.3]), None))
    one.frames_until(lambda: run.over)
    assert len(run.walk.done.tries) == 2 and session.simulation.time == pytest.approx(10.0, abs=0.1)


def test_what_a_student_changed_pushed_and_typed_is_taken_up_again() -> None:
    one = Student(2, 2)
    session, run = one.session, one.run
    one.to_challenge()
    session.change("v", 0.17)
    run.said.extend([0.25, None, 0.5])
    run.walk.kept["push"] = NO_TARGETS
    saved = run.saved_lesson()
    assert saved is not None
    other = Session(Settings())
    again = LessonSession(other, BOOK)
    again.resume(saved, reopen=True)
    assert other.settings.run == session.settings.run and other.settings.run.law.nominal_velocity == 0.17
    assert again.said == [0.25, None, 0.5] and dict(again.walk.kept) == dict(run.walk.kept)
    again.act(do.Press("leave"))
    assert other.settings == Settings()
    again.enter(2, 2)
    again.act(do.Press("reset"))
    assert again.said == []


PRESSES = 2 * (do.Press("next"), do.Press("run")) + tuple(
    do.Press(what) for what in ("back", "again", "reset", "why", "check", "hint", "leave")
)


class WildStudent(Student):
    """Does anything, in any order, the same for the same seed."""

    def __init__(self, seed: int) -> None:
        self.rng = random.Random(seed)
        super().__init__(self.rng.randrange(len(BOOK.lessons)))

    def act(self) -> None:
        others = (do.Choose(self.rng.randrange(6)), do.GoTo(self.rng.randrange(12), self.rng.randrange(6)))
        self.run.act(self.rng.choice((*others, *PRESSES)))

    def meddle(self) -> None:
        """One thing a student may do with the controls, the handles or the tab."""
        session, rng = self.session, self.rng
        place = np.array([rng.uniform(-1.0, 1.0) for _ in range(3)])
        match rng.choice(
            ("pause", "step", "reset", "setting", "setting", "hold", "let go", "autopilot", "", "", "reload")
        ):
            case "pause":
                session.control.toggle_pause()
            case "step":
                session.control.single_step()
            case "reset":
                session.reset()
            case "setting":
                key, spec = rng.choice(list(specs(Settings).items()))
                number = (
                    rng.uniform(spec.low, spec.high)
                    if math.isfinite(spec.high - spec.low)
                    else rng.random() < 0.5
                )
                with contextlib.suppress(BadSetting):
                    session.change(key, rng.choice(spec.choices) if spec.choices else number)
            case "hold" if not self.run.hands_off:
                session.hand.hold(rng.choice((HandTarget(place), BallTarget(place))))
            case "let go":
                session.hand.hold(None)
            case "autopilot":
                session.change("autopilot", not session.settings.page.autopilot)
            case "reload":
                saved = self.run.saved_lesson()
                assert saved is not None
                self.session = Session(Settings())
                self.run = LessonSession(self.session, BOOK)
                self.run.resume(saved, reopen=True)
            case _:
                for _ in range(rng.randrange(1, 60)):
                    self.frame(0.1)


@pytest.mark.usefixtures("fast_machine")
@pytest.mark.parametrize("seed", [3, 7])
def test_whatever_is_done_there_is_a_way_on_and_a_fresh_start(
    seed: int, caplog: pytest.LogCaptureFixture
) -> None:
    student = WildStudent(seed)
    for _ in range(30):
        student.rng.choice((student.act, student.meddle))()
        student.frame(0.03)
        if not student.run.open:
            student.run.enter()
    run, here = student.run, student.run.walk.step
    last = run.walk.lesson is BOOK.lessons[-1] and here is run.walk.lesson.steps[-1]
    for _ in range(20):
        if run.walk.locked:
            run.act(do.Choose(0))
        run.runner.further.result(60.0)
        run.act(do.Press("next"))
        student.frame(0.03)
    assert run.walk.step is not here or (last and run.walk.phase is run.walk.phases[-1]), "next gets on"
    run.act(do.Press("reset"))
    student.frame(0.03)
    assert run.walk.phase is run.walk.phases[0] and (student.session.paused or not run.walk.locked)
    if run.walk.locked:
        run.act(do.Choose(0))
    assert run.walk.phase is Phase.DO
    student.session.change("speed", 2.0)
    student.session.control.halt.go_on()
    run.runner.further.result(60.0)
    student.frames_until(lambda: run.walk.phase is not Phase.DO or run.walk.yours, 0.1)
    assert not [record for record in caplog.records if record.exc_info], caplog.text


def test_the_list_opens_lessons_and_knows_what_is_finished() -> None:
    session = Session(Settings())
    run = LessonSession(session, BOOK)
    run.act(do.Press("list"))
    assert run.listing and not run.open
    assert not any(entry.here or any(entry.finished) or entry.step for entry in run.walk.entries())
    run.act(do.Press("list"))
    assert not run.listing
    run.act(do.GoTo(1, 0))
    assert not run.open, "no lesson without the list"
    run.act(do.Press("list"))
    run.act(do.GoTo(1, 0))
    assert run.open and not run.listing and run.walk.lesson is BOOK.lessons[1]

    student = Student(1)
    run = student.run
    run.act(do.Choose(0))
    student.finish()
    run.act(do.Press("next"))
    run.act(do.GoTo(1, 1))
    entry = tuple(run.walk.entries())[1]
    assert entry.here and entry.finished == (True, False, False) and entry.step == 1
    assert [one.here for one in run.walk.entries()].count(True) == 1
    run.act(do.GoTo(0, 0))
    # Where the student is not any more, the first step that is open comes next.
    assert tuple(run.walk.entries())[1].step == 1 and not tuple(run.walk.entries())[1].here


def test_what_was_learned_is_said_at_the_end_of_a_lesson() -> None:
    student = Student(2, 2)
    run = student.run
    assert not run.walk.view().lesson_finished
    student.to_challenge()
    assert not run.walk.view().lesson_finished, "the challenge is not passed yet"
    run.walk.done.passed = True
    view = run.walk.view()
    assert view.lesson_finished and BOOK.lessons[2].learned and "q" in learned_html(view)
    run.act(do.GoTo(2, 0))
    assert not run.walk.view().lesson_finished and learned_html(run.walk.view()) == ""
