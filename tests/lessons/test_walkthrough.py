"""A student in the lessons: what is locked, what is remembered, and that nothing gets stuck, whatever they do."""

import ast
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from app.lessons import FOLDER
from app.lessons.lesson import LessonBook
from app.lessons.own_law import StandIn, examine, stand_in
from app.lessons.progress import Progress, from_json, to_json
from app.lessons.trials import begin, person_of, simulated
from app.lessons.walkthrough import Phase, Walkthrough
from app.own_law.trials import WHY
from app.settings import PageSettings, Settings
from controllers.errors import BadSetting
from controllers.laws.situation import Situation
from scenes.cast import Nobody
from scenes.settings import RunSettings, changed
from scenes.simulation import Simulation
from scenes.targets import HandTarget
from tests.lessons.helpers import SMALL, book_of, our_book, run_out, small_walk, to_challenge


@pytest.fixture
def walk(tmp_path: Path) -> Walkthrough:
    """A fresh walkthrough of the small lesson."""
    return small_walk(tmp_path)


def test_the_engine_knows_no_page() -> None:
    """Nothing in the package imports what draws, nor the page that will show it."""
    for path in FOLDER.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert not any(name.split(".")[0] in ("viser", "tyro") or name.startswith("app.page") for name in names), path.name


# ---- the order of things ------------------------------------------------------------------------------------------------------


def test_nothing_runs_before_an_answer_is_chosen(walk: Walkthrough) -> None:
    """Locked, and `next` does not help; a choice that is none does not either."""
    assert walk.locked and walk.phase is Phase.PREDICT and not walk.view().can_next
    assert not walk.next() and not walk.choose(2) and not walk.choose(-1)
    assert walk.locked
    assert walk.choose(0)
    assert not walk.locked and walk.phase is Phase.DO


def test_goal_predict_do_observe_explain_challenge(walk: Walkthrough) -> None:
    """Each phase adds its text, the equation after the experience; then the next step."""
    seen: list[tuple[str, ...]] = [tuple(name for name, _ in walk.view().texts)]
    walk.choose(1)
    run_out(walk)
    for _ in range(5):
        seen.append(tuple(name for name, _ in walk.view().texts))
        if not walk.next():
            break
    everything = ("goal", "predict", "do", "observe", "explain", "challenge")
    assert seen[:4] == [everything[:2], everything[:4], everything[:5], everything]
    assert walk.step.id == "second" and walk.phase is Phase.OBSERVE
    assert not walk.next() and not walk.view().can_next


def test_the_verdict_has_the_choice_the_outcome_and_the_reason(walk: Walkthrough) -> None:
    """Right and wrong; the numbers of this run are in the reply."""
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
    """Another run, another number; the numbers before the run are those of the comparison."""
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
    """Half a run is measured, but not kept; whoever goes on gets the reference run, and is told so."""
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
    """Not afterwards."""
    walk.choose(0)
    assert walk.choose(1) and walk.done.choice == 1
    run_out(walk)
    assert not walk.choose(0) and walk.done.choice == 1
    walk.back()
    assert walk.phase is Phase.DO and not walk.choose(0)
    assert not walk.back() and walk.phase is Phase.DO


def test_looking_back_at_the_question_keeps_the_answer(walk: Walkthrough) -> None:
    """Nothing runs while the question is read again; the answer is still there, and `next` leads on with it."""
    walk.choose(0)
    assert walk.back() and walk.locked and walk.done.choice == 0 and walk.view().can_next
    assert walk.next() and walk.phase is Phase.DO and walk.done.choice == 0
    walk.back()
    assert walk.choose(1) and walk.phase is Phase.DO and walk.done.choice == 1


def test_the_run_that_shows_why(walk: Walkthrough) -> None:
    """Only for the wrong answer; with its own settings and outcome, and a way back."""
    walk.choose(1)
    run_out(walk)
    assert not walk.view().why and not walk.show_why()
    walk.reset()
    walk.choose(0)
    assert not walk.show_why()
    run_out(walk)
    turn = walk.turn
    assert walk.view().why and walk.show_why() and walk.turn == turn + 1
    assert walk.settings().run.law.order == 6.0
    run_out(walk)
    assert walk.done.why is not None and walk.view().why_outcome and walk.view().showing
    assert walk.next() and not walk.view().showing and walk.phase is Phase.OBSERVE
    assert walk.settings().run.law.order == 2.0


def test_back_and_forward_keep_what_was_done(walk: Walkthrough) -> None:
    """Walk to the end and back to the beginning: the answer, the outcome and the attempt are still there."""
    walk.choose(0)
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


def test_hints_open_one_after_another(walk: Walkthrough) -> None:
    """Three, then no more."""
    assert walk.view().hints == () and walk.view().more_hints
    assert [walk.hint() for _ in range(4)] == ["One.", "Two.", "Three.", None]
    assert walk.view().hints == ("One.", "Two.", "Three.") and not walk.view().more_hints


def test_reset_equals_a_fresh_start(walk: Walkthrough, tmp_path: Path) -> None:
    """Whatever was done in the step."""
    fresh = Walkthrough(walk.book).view()
    walk.choose(0)
    run_out(walk)
    walk.show_why()
    run_out(walk)
    to_challenge(walk)
    walk.attempt(simulated(walk.setup))
    walk.hint()
    walk.write("mine")
    assert walk.view() != fresh
    walk.reset()
    assert walk.view() == fresh
    # But for their own words, which nobody writes twice.
    assert replace(walk.done, words="").untouched and walk.done.words == "mine"


# ---- challenges ---------------------------------------------------------------------------------------------------------------


def test_a_failed_challenge_says_which_inequality_and_by_how_much(walk: Walkthrough) -> None:
    """And a passed one is remembered, whatever comes after."""
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
    """Changed before the first step they do."""
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
    """Whatever its inequalities say so far; and what happens after its end does not count either."""
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
    """5 % off passes, 6 % does not, nothing said does not; the truth is the first jump of each run."""
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
    """Lesson 6: until there is something, the script pushes; then the student's own push does."""
    walk = Walkthrough(our_book())
    walk.go("hold", 3)
    simulation = Simulation(walk.settings().run)
    script = walk.target_source(simulation).target(2.0)
    assert isinstance(script, HandTarget)
    own = person_of(simulation, walk.setup)
    walk.go("hold", 2)
    assert walk.yours and isinstance(walk.target_source(simulation), Nobody)
    to_challenge(walk)
    attempt = walk.attempt(simulated(walk.step.trials[0].setup), person=own)
    assert attempt is not None and attempt.passed
    walk.go("hold", 3)
    assert walk.target_source(simulation) is own


def test_marks_are_where_the_elbow_can_be() -> None:
    """Lesson 1: on the elbow's circle, more than 8 cm apart."""
    walk = Walkthrough(our_book())
    walk.go("redundancy", 2)
    simulation = Simulation(walk.settings().run)
    marks = walk.marks(simulation)
    assert marks.shape == (2, 3) and np.linalg.norm(marks[1] - marks[0]) > 0.08
    kinematics, arm = simulation.kinematics, simulation.avoiding
    kinematics.update(simulation.positions)
    for joint in (arm.shoulder, arm.wrist):
        centre, elbow = kinematics.joint_point(joint), kinematics.joint_point(arm.elbow)
        assert_allclose(np.linalg.norm(marks - centre, axis=1), np.linalg.norm(elbow - centre), atol=1e-12)


# ---- the run that a page makes ------------------------------------------------------------------------------------------------


def test_the_run_has_the_lessons_settings_and_the_pages_own_look(walk: Walkthrough) -> None:
    """A dark theme stays dark; a setting of the run that the visitor had does not stay."""
    before = Settings(RunSettings(scene="hold", gain=7.0), PageSettings(theme="dark"))
    after = walk.settings(before)
    assert after.page.theme == "dark"
    assert after.run.scene == "ball" and after.run.law.order == 2.0 and after.run.gain == RunSettings().gain


def test_every_run_of_every_lesson_can_be_begun_as_a_page_does_it() -> None:
    """`settings`, `start` and `target_source` for every step and challenge, and the live numbers before and after a step."""
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
    """`turn` goes up with every answer, challenge, reset and step, and not by looking on from OBSERVE to EXPLAIN."""
    turn = walk.turn
    walk.choose(0)
    assert walk.turn == turn + 1
    run_out(walk)
    assert walk.phase is Phase.OBSERVE and walk.turn == turn + 1
    walk.next()
    assert walk.phase is Phase.EXPLAIN and walk.turn == turn + 1
    walk.next()
    assert walk.phase is Phase.CHALLENGE and walk.turn == turn + 2
    walk.next()
    walk.reset()
    assert walk.turn == turn + 4


def test_going_to_a_step_that_is_not_there_is_refused(walk: Walkthrough) -> None:
    """And nothing has moved."""
    before = walk.view()
    for lesson, step in (("none", 0), (7, 0), (-1, 0), ("small", 2), ("small", -1)):
        with pytest.raises(BadSetting):
            walk.go(lesson, step)
    assert walk.view() == before
    with pytest.raises(BadSetting, match="no lesson"):
        Walkthrough(LessonBook((), ()))


# ---- whatever the student does ------------------------------------------------------------------------------------------------

ACTIONS = st.lists(
    st.one_of(
        st.sampled_from(
            ["next", "back", "reset", "why", "hint", "observe", "attempt", "run", "reload", "again", "write", "reset_all"]
        ),
        st.tuples(st.just("choose"), st.integers(-1, 3)),
        st.tuples(st.just("go"), st.integers(-1, 2), st.integers(-1, 2)),
        st.tuples(st.just("set"), st.sampled_from([("n", 6.0), ("point", "elbow"), ("scene", "solo"), ("law", "unprotected")])),
    ),
    max_size=25,
)


class Student:
    """Does things, and a page that goes along."""

    def __init__(self, book: LessonBook) -> None:
        self.walk = Walkthrough(book)
        self._turn = -1
        self._follow()

    def _follow(self) -> None:
        if self._turn != self.walk.turn:
            self._turn = self.walk.turn
            self.simulation = Simulation(self.walk.settings().run, 200)
            self.simulation.reset(self.walk.start(self.simulation))
            self._person = self.walk.target_source(self.simulation)

    def do(self, action: str | tuple[object, ...]) -> None:
        """One thing."""
        walk, simulation = self.walk, self.simulation
        match action:
            case "next":
                assert walk.view().can_next == walk.next()
            case "back":
                assert walk.view().can_back == walk.back()
            case "reset":
                walk.reset()
            case "reset_all":
                walk.reset_all()
            case "why":
                walk.show_why()
            case "hint":
                walk.hint()
            case "observe":
                walk.observe(simulation)
            case "attempt":
                walk.attempt(simulation, [0.5, None])
            case "again":
                walk.run_again()
            case "write":
                walk.write("words " * 1000)
            case "run":
                for _ in range(120):
                    walk.watch(simulation)
                    simulation.step(self._person.target(simulation.time))
            case "reload":
                before = walk.view()
                self.walk = Walkthrough.from_json(walk.book, walk.to_json())
                if not before.showing:
                    assert self.walk.view() == before
                self._turn = -1
            case ("choose", int(answer)):
                walk.choose(answer)
            case ("go", int(lesson), int(step)):
                if 0 <= lesson < len(walk.book.lessons) and 0 <= step < len(walk.book.lessons[lesson].steps):
                    walk.go(lesson, step)
            case ("set", (str(key), value)):
                simulation.apply(changed(simulation.settings, key, value))
        self._follow()


@given(actions=ACTIONS)
@settings(max_examples=120)
def test_nothing_a_student_does_raises_or_gets_stuck(tmp_path_factory: pytest.TempPathFactory, actions: list[str]) -> None:
    """After any row of actions there is a way on to the end, a way back to the beginning, and reset is a fresh start."""
    book = two_lessons(tmp_path_factory.getbasetemp())
    student = Student(book)
    for action in actions:
        student.do(action)
        view = student.walk.view()
        assert view.locked == (view.phase is Phase.PREDICT)
        assert view.phase in view.phases
    walk = student.walk
    lesson, step = walk.lesson.id, walk.view().index
    walk.reset()
    fresh = Walkthrough(book)
    fresh.go(lesson, step)
    assert {**vars(walk.view()), "can_back": 0} == {**vars(fresh.view()), "can_back": 0}
    for _ in range(40):
        if walk.locked:
            assert walk.choose(0)
        elif not walk.next():
            break
    assert walk.lesson is book.lessons[-1] and walk.step is book.lessons[-1].steps[-1] and walk.phase is walk.phases[-1]
    for _ in range(40):
        if not walk.back():
            break
    assert walk.lesson is book.lessons[0] and walk.step is book.lessons[0].steps[0]


_books: dict[Path, LessonBook] = {}


def two_lessons(folder: Path) -> LessonBook:
    """The small lesson twice; read once."""
    folder = folder / "two"
    if folder not in _books:
        folder.mkdir(exist_ok=True)
        book_of(folder)
        _books[folder] = book_of(folder, name="02-again.md")
    return _books[folder]


# ---- what survives a reload ---------------------------------------------------------------------------------------------------


def test_everything_survives_a_reload(walk: Walkthrough) -> None:
    """Answer, outcome, attempts, hints, words and place."""
    walk.choose(0)
    run_out(walk)
    walk.show_why()
    run_out(walk)
    walk.next()
    to_challenge(walk)
    walk.attempt(simulated(walk.setup))
    walk.hint()
    walk.write("It was the tail.")
    text = walk.to_json()
    again = Walkthrough.from_json(walk.book, text)
    assert again.view() == walk.view() and again.done == walk.done
    assert again.to_json() == text
    assert again.done.words == "It was the tail." and again.phase is Phase.CHALLENGE


def test_an_infinite_distance_survives(walk: Walkthrough) -> None:
    """JSON has no infinity; the lessons have."""
    walk.choose(0)
    run_out(walk)
    outcome = walk.done.outcome
    assert outcome is not None
    text = walk.to_json().replace(str(outcome.values[0][0]), '"inf"')
    again = Walkthrough.from_json(walk.book, text)
    assert again.done.outcome is not None and again.done.outcome.values[0][0] == np.inf


def test_a_lesson_that_has_changed_meanwhile_keeps_what_still_fits(tmp_path: Path) -> None:
    """One answer and one comparison fewer: the answer that is gone is forgotten, the rest is not."""
    walk = small_walk(tmp_path)
    walk.choose(1)
    run_out(walk)
    walk.hint()
    text = walk.to_json()
    shorter = SMALL.replace("compare = [{ n = 4.0 }]\n", "").replace("With n = 4 it is {measured:d:1}.", "")
    again = Walkthrough.from_json(book_of(tmp_path, shorter), text)
    assert again.done.choice == 1 and again.done.outcome is None and again.done.hints == 1
    assert again.phase is Phase.DO
    gone = Walkthrough.from_json(book_of(tmp_path, SMALL.replace('id = "first"', 'id = "other"')), text)
    assert gone.phase is Phase.PREDICT and gone.done.untouched


@given(data=st.recursive(
    st.none() | st.booleans() | st.integers(-5, 5) | st.floats(allow_nan=False) | st.sampled_from(["first", "small", "inf", "do", ""]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(
        st.sampled_from(["version", "lesson", "step", "phase", "steps", "choice", "outcome", "values", "unlike", "last", "judgements",
                         "hints", "attempts", "passed", "words", "why"]), inner, max_size=6),
    max_leaves=20,
))  # fmt: skip
@settings(max_examples=300)
def test_nonsense_is_a_fresh_start_or_what_can_be_read_of_it(tmp_path_factory: pytest.TempPathFactory, data: object) -> None:
    """Whatever a browser has kept: nothing raises, and what comes out can be shown and kept again."""
    book = two_lessons(tmp_path_factory.getbasetemp())
    if isinstance(data, dict):
        data = {"version": 1, "steps": [{"lesson": "small", "step": "first", **data}], "lesson": "small", "step": "first"} | data
    walk = Walkthrough.from_json(book, json.dumps(data))
    walk.view()
    assert from_json(walk.to_json()) is not None
    assert walk.choose(0) == (walk.done.outcome is None)


@pytest.mark.parametrize("text", ["", "{", "[]", "null", '{"version": 2}', "[" * 100_000, '{"version": 1, "steps": 7}'])
def test_what_is_no_progress_at_all(walk: Walkthrough, text: str) -> None:
    """A fresh start."""
    assert Walkthrough.from_json(walk.book, text).view() == walk.view()
    assert to_json(Progress()) == to_json(from_json(text))


# ---- a controller of one's own ------------------------------------------------------------------------------------------------


def textbook(s: Situation) -> np.ndarray:
    """Eq. (32) with the undamped pseudo-inverse."""
    lam = 1.0 if s.distance <= 0.15 else (0.15 / s.distance) ** 6
    square = float(s.row @ s.row)
    return s.nominal + s.row * (lam * (0.3 + s.pull) / square) if square else s.nominal


def test_the_textbooks_law_fails_where_there_is_no_lever() -> None:
    """The reason says how fast it wanted to be, and why that is asked."""
    attempt = examine(StandIn(textbook), ("gets out", "bounded where J_d is singular"))
    assert attempt.failed == ("bounded where J_d is singular",)
    (judgement,) = [j for j in attempt.judgements if not j.passed]
    assert judgement.text.startswith("Bounded where J_d is singular: |q̇| ≤ 1.92 rad/s")
    assert "fails by" in judgement.text and judgement.text.endswith(WHY[judgement.id])


def test_own_law_attempts_are_noted() -> None:
    """By the judgements that a loader brings; there is nothing else to attempt in that step."""
    walk = Walkthrough(our_book())
    walk.go("limits", 3)
    assert walk.attempt_own_law(()) is None
    to_challenge(walk)
    assert walk.attempt(simulated(walk.setup)) is None
    judgements = examine(stand_in("unprotected"), only=("leaves the task alone", "gets out")).judgements
    failed = walk.attempt_own_law(judgements)
    assert failed is not None and failed.failed == ("gets out",) and "fails by" in failed.text
    passed = walk.attempt_own_law([judgement for judgement in judgements if judgement.passed])
    assert passed is not None and walk.done.passed and walk.done.attempts == 2
