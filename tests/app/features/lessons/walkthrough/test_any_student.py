"""Progress after a reload: complete, partly fitting, or empty. See also `test_lesson_machine.py`."""

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.features.lessons.bookmark import Phase
from app.features.lessons.lesson import LessonBook
from app.features.lessons.progress import Progress, from_json, to_json
from app.features.lessons.reference_runs import simulated
from app.features.lessons.walkthrough import Walkthrough
from tests.app.features.lessons.helpers import SMALL, book_of, run_out, to_challenge


@cache
def two_lessons(folder: Path) -> LessonBook:
    (folder / "two").mkdir(exist_ok=True)
    book_of(folder / "two")
    return book_of(folder / "two", name="02-again.md")


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


def test_a_changed_lesson_keeps_the_progress_that_still_fits(walk: Walkthrough, tmp_path: Path) -> None:
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
def test_invalid_progress_gives_a_fresh_start_or_its_readable_part(
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
def test_text_without_progress_gives_a_fresh_start(walk: Walkthrough, text: str) -> None:
    assert Walkthrough(walk.book, text).view() == walk.view()
    assert to_json(Progress()) == to_json(from_json(text))
