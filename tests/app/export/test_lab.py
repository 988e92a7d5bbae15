"""The lab report on lessons: what was predicted stands beside what came out, with the run of the student or the very same one again."""

from __future__ import annotations

import pickle
import re
from dataclasses import replace

import pytest

from app.export.export_queue import ExportQueue
from app.export.lab_report import Done, done_in, lab_bytes, recorded_of, report_title, rich_html
from app.export.report_html import LOCKED
from app.hosting.resume import open_link
from app.hosting.session_store import SessionStore, VisitorRecord
from app.lessons.loading import load_lessons
from app.lessons.phases import Phase
from app.lessons.progress import MOST_WORDS
from app.lessons.reference_runs import simulated
from app.lessons.session.lesson_actions import Choose, ResetStep, StartOrPause
from app.lessons.session.lesson_session import LessonSession
from app.session.session import Session
from app.settings import Settings
from scenes.rerun import rerun
from tests.app.inline import Inline

BOOK = load_lessons()
NASTY = "<script>alert(1)</script>"


@pytest.fixture(scope="module")
def run() -> LessonSession:
    """Lesson 1, its first step seen to its end, with a wrong answer; only to be read."""
    run = LessonSession(Session(Settings()), BOOK)
    run.enter(0)
    run.act(Choose(3))
    while not run._runs.ready:
        pass
    run.act(StartOrPause())
    while run.walk.phase is Phase.DO:
        run._session.advance(0.05)
        run.decide()
    run.walk.write(f"I did not expect that.\n{NASTY}")
    return run


def steps_of(run: LessonSession, only: str | None = None) -> tuple[Done, ...]:
    """What was done in the lessons."""
    return done_in(run.book.lessons, run.walk.done_in, run.seen, only)


def made(done: tuple[Done, ...]) -> str:
    """The report."""
    return lab_bytes(done, "en").decode()


def test_prediction_outcome_plots_settings_and_own_words(run: LessonSession) -> None:
    (done,) = steps_of(run)
    page = made((done,))
    question = done.step.question
    assert question is not None and done.progress.outcome is not None and not done.progress.outcome.reference
    for part in (
        "<h1>Lab report: lesson 1, Redundancy and null space</h1>",
        "<h3>1.1  What is left over</h3>",
        "✗ not so</span>In 7: every joint can still be moved.",
        *done.progress.outcome.lines(done.step, "en"),
        "scene = One arm alone (eqs 1–8)",
        "I did not expect that.\n&lt;script&gt;alert(1)&lt;/script&gt;",
    ):
        assert part in page.replace("&#x27;", "'")
    assert page.count("<figure>") == 1 and "hand error" in page and "elbow angle" in page
    assert LOCKED in page and NASTY not in page and not re.search(r"""(src|href)=["']?(https?:)?//""", page)


def test_the_run_in_it_is_the_students_own_and_else_the_same_one_again(run: LessonSession) -> None:
    (done,) = steps_of(run)
    assert done.seen is not None
    again = recorded_of(done.step.setup)
    assert again is not None
    table = rerun(again).table
    assert table.tobytes() == simulated(done.step.setup).history.table(len(table)).tobytes()
    assert rerun(done.seen).table[: len(table)].tobytes() == table.tobytes()
    assert made((replace(done, seen=None),)).count("<figure>") == 1
    # What a hand was in cannot be made again, and what was not seen is not shown.
    yours = next(i for i, step in enumerate(done.lesson.steps) if step.yours)
    progress = replace(done.progress, choice=None, outcome=None)
    assert made((Done(done.lesson, yours, progress),)).count("<figure>") == 0


def test_only_what_was_done_is_in_it(run: LessonSession) -> None:
    assert [(one.lesson.number, one.index) for one in steps_of(run)] == [(1, 0)]
    assert steps_of(run, BOOK.lessons[1].id) == () and len(steps_of(run, BOOK.lessons[0].id)) == 1
    assert not LessonSession(Session(Settings()), BOOK).begun and run.begun
    both = (*steps_of(run), Done(BOOK.lessons[1], 0, steps_of(run)[0].progress))
    assert report_title(both) == "Lab report"


def test_formulas_are_drawn_and_paragraphs_kept() -> None:
    assert "<svg" in rich_html(r"speed $\lambda v$") and "<p>" not in rich_html("one line")
    assert rich_html("2 d_m < J_d") == "2 d<sub>m</sub> &lt; J<sub>d</sub>" and rich_html("my_law.py") == "my_law.py"
    assert rich_html("a\n\nb").split() == ["<p>a</p>", "<p>b</p>"] and "<svg" in rich_html("$$x$$")


def test_the_shelf_makes_it_as_a_file(run: LessonSession) -> None:
    background = Inline()
    shelf = ExportQueue(run._session, background)
    shelf.ask_report(())
    assert [news.title for news in shelf.take_news()] == ["There is nothing to report yet"] and not background.waiting()
    shelf.ask_report(steps_of(run))
    assert shelf.busy == "the lab report"
    (job,) = background.waiting()
    # It goes to another process, with what was written until now.
    pickle.loads(pickle.dumps(job.arguments))
    before = run.walk.done.words
    run.walk.write("later")
    background.work()
    run.walk.write(before)
    shelf.player.advance(0.0)
    ((name, content),) = shelf.take_files()
    assert name == "duet-lab-report-lesson-1.html" and b"I did not expect" in content and b"later" not in content


def test_words_and_runs_survive_a_reload_and_a_reset_spares_the_words(run: LessonSession) -> None:
    store, query = SessionStore(), {"resume": "0123456789abcdef"}
    store.save(VisitorRecord(query, Settings(), run.saved()))
    back = LessonSession(Session(Settings()), BOOK)
    assert open_link(back, query, store.find(query)) == ()
    assert back.walk.done.words == run.walk.done.words and back.seen == run.seen
    back.act(ResetStep())
    assert back.walk.done.words == run.walk.done.words and back.walk.done.choice is None
    back.walk.write("x" * (MOST_WORDS + 1), BOOK.lessons[2].id, BOOK.lessons[2].steps[0].id)
    assert len(back.walk.done_in(BOOK.lessons[2].id, BOOK.lessons[2].steps[0].id).words) == MOST_WORDS
