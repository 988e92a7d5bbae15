"""Whatever a student does, nothing gets stuck; what survives a reload: all of it, what still fits of it, and of nonsense a fresh start."""

import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.features.lessons.bookmark import Phase
from app.features.lessons.lesson import LessonBook
from app.features.lessons.progress import Progress, from_json, to_json
from app.features.lessons.reference_runs import begin_reference_run, person_of, simulated
from app.features.lessons.walkthrough import Walkthrough
from scenes.settings import changed
from scenes.simulation import Simulation
from tests.app.features.lessons.helpers import SMALL, book_of, run_out, to_challenge

SIMPLE = (
    "next",
    "back",
    "reset",
    "show_why",
    "hint",
    "run_again",
    "observe",
    "attempt",
    "run",
    "reload",
    "write",
)
ACTIONS = st.lists(
    st.one_of(
        st.sampled_from(SIMPLE),
        st.tuples(st.just("choose"), st.integers(-1, 3)),
        st.tuples(st.just("go"), st.integers(-1, 2), st.integers(-1, 2)),
        st.tuples(
            st.just("set"),
            st.sampled_from([("n", 6.0), ("point", "elbow"), ("scene", "solo"), ("law", "unprotected")]),
        ),
    ),
    max_size=25,
)


@cache
def two_lessons(folder: Path) -> LessonBook:
    (folder / "two").mkdir(exist_ok=True)
    book_of(folder / "two")
    return book_of(folder / "two", name="02-again.md")


class Student:
    def __init__(self, book: LessonBook) -> None:
        self.walk = Walkthrough(book)
        self._turn = -1
        self._follow()

    def _follow(self) -> None:
        if self._turn != self.walk.run_id:
            self._turn = self.walk.run_id
            self.simulation = Simulation(self.walk.setup.run, 200)
            begin_reference_run(self.simulation, self.walk.setup)
            self._person = person_of(self.simulation, self.walk.setup, self.walk.kept)

    def do(self, action: str | tuple[object, ...]) -> None:
        walk, simulation = self.walk, self.simulation
        match action:
            case "next":
                assert walk.view().can_next == walk.next()
            case "back":
                assert walk.view().can_back == walk.back()
            case "reset" | "show_why" | "hint" | "run_again":
                getattr(walk, action)()
            case "observe":
                walk.observe(simulation)
            case "attempt":
                walk.attempt(simulation, [0.5, None])
            case "write":
                walk.write("words " * 1000)
            case "run":
                for _ in range(120):
                    walk.watch(simulation)
                    simulation.step(self._person.target(simulation.time))
            case "reload":
                before = walk.view()
                self.walk = Walkthrough(walk.book, walk.to_json())
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
def test_nothing_a_student_does_raises_or_gets_stuck(
    tmp_path_factory: pytest.TempPathFactory, actions: list[str]
) -> None:
    book = two_lessons(tmp_path_factory.getbasetemp())
    student = Student(book)
    for action in actions:
        student.do(action)
        view = student.walk.view()
        assert (
            view.locked == (view.phase is Phase.PREDICT and not view.done.predicted)
            and view.phase in view.phases
        )
    walk = student.walk
    lesson, step = walk.lesson.id, walk.view().index
    walk.reset()
    fresh = Walkthrough(book)
    fresh.go(lesson, step)
    # What was written stays.
    done = replace(walk.done, words="")
    assert {**vars(walk.view()), "can_back": 0, "done": done} == {**vars(fresh.view()), "can_back": 0}
    for _ in range(40):
        if walk.locked:
            assert walk.choose(0)
        elif not walk.next():
            break
    assert (
        walk.lesson is book.lessons[-1]
        and walk.step is book.lessons[-1].steps[-1]
        and walk.phase is walk.phases[-1]
    )
    for _ in range(40):
        if not walk.back():
            break
    assert walk.lesson is book.lessons[0] and walk.step is book.lessons[0].steps[0]


def test_everything_survives_a_reload(walk: Walkthrough) -> None:
    walk.choose(0)
    run_out(walk)
    walk.show_why()
    run_out(walk)
    walk.next()
    to_challenge(walk)
    walk.attempt(simulated(walk.setup))
    walk.hint()
    walk.write("It was the tail.")
    walk.give_reason("λ falls fast", walk.lesson.id, walk.step.id)
    text = walk.to_json()
    again = Walkthrough(walk.book, text)
    assert again.view() == walk.view() and again.done == walk.done
    assert again.to_json() == text
    assert (
        again.done.words == "It was the tail."
        and again.done.because == "λ falls fast"
        and again.phase is Phase.CHALLENGE
    )
    outcome = walk.done.outcome
    assert outcome is not None
    endless = Walkthrough(walk.book, text.replace(str(outcome.values[0][0]), '"inf"')).done.outcome
    assert endless is not None and endless.values[0][0] == np.inf


def test_a_lesson_that_has_changed_meanwhile_keeps_what_still_fits(walk: Walkthrough, tmp_path: Path) -> None:
    walk.choose(1)
    run_out(walk)
    walk.hint()
    text = walk.to_json()
    shorter = SMALL.replace("compare = [{ n = 4.0 }]\n", "").replace("With n = 4 it is {measured:d:1}.", "")
    again = Walkthrough(book_of(tmp_path, shorter), text)
    assert again.done.choice == 1 and again.done.outcome is None and again.done.hints == 1
    assert again.phase is Phase.DO
    gone = Walkthrough(book_of(tmp_path, SMALL.replace('id = "first"', 'id = "other"')), text)
    assert gone.phase is Phase.PREDICT and gone.done.untouched


@given(data=st.recursive(
    st.none() | st.booleans() | st.integers(-5, 5) | st.floats(allow_nan=False) | st.sampled_from(["first", "small", "inf", "do", ""]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(
        st.sampled_from(["version", "lesson", "step", "phase", "steps", "choice", "outcome", "values", "unlike", "last", "judgements",
                         "hints", "attempts", "passed", "words", "why"]), inner, max_size=6),
    max_leaves=20,
))  # fmt: skip
@settings(max_examples=300)
def test_nonsense_is_a_fresh_start_or_what_can_be_read_of_it(
    tmp_path_factory: pytest.TempPathFactory, data: object
) -> None:
    book = two_lessons(tmp_path_factory.getbasetemp())
    if isinstance(data, dict):
        data = {
            "version": 1,
            "steps": [{"lesson": "small", "step": "first", **data}],
            "lesson": "small",
            "step": "first",
        } | data
    walk = Walkthrough(book, json.dumps(data))
    walk.view()
    assert from_json(walk.to_json()) is not None
    assert walk.choose(0) == (walk.done.outcome is None)


@pytest.mark.parametrize(
    "text", ["", "{", "[]", "null", '{"version": 2}', "[" * 100_000, '{"version": 1, "steps": 7}']
)
def test_what_is_no_progress_at_all(walk: Walkthrough, text: str) -> None:
    assert Walkthrough(walk.book, text).view() == walk.view()
    assert to_json(Progress()) == to_json(from_json(text))
