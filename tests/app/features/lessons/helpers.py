"""Shared by tests of the lessons: the text of a small lesson, and paths through a walkthrough."""

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Protocol

from playwright.sync_api import Page

from app.features.lessons.bookmark import Phase
from app.features.lessons.lesson import Lesson, LessonBook
from app.features.lessons.loading import load_lessons
from app.features.lessons.outcomes import Attempt, Judgement, reference
from app.features.lessons.progress import Progress, SavedLesson, StepProgress, from_json
from app.features.lessons.reference_runs import simulated
from app.features.lessons.session.lesson_session import LessonSession
from app.features.lessons.walkthrough import Walkthrough
from app.hosting.visitor_record import VisitorRecord, part_of
from app.plots.curve_chart import COLUMNS
from app.session.session import Session
from app.settings import Settings
from controllers.errors import LazyText


def unfold_controls(page: Page) -> None:
    """Unfold the right panel, which is folded while a lesson is open."""
    page.locator("[data-dock-region=right] [data-dock-minimize-all][aria-expanded=false]").click()


# "nobody" is the name of "none" in files of earlier versions.
SMALL = """# A small lesson

Find out something.

```duet
equations = "31"
settings = { scene = "ball", point = "hand", pairs = "single", dt = 0.02, n = 2.0 }
```

## First

```duet
id = "first"
input = "nobody"
seconds = 2.0
plots = ["distance"]
numbers = ["distance_now"]
right = 2
expects = [[0.0, 0.05], [0.05, 9.0]]

[[measure]]
id = "d"
name = "smallest_distance"
compare = [{ n = 4.0 }]

[[why]]
choice = 1
settings = { n = 6.0 }

[challenge]
seconds = 2.0

[[challenge.criterion]]
id = "n"
name = "setting"
key = "n"
at_least = 5.0

[[attempt]]
name = "more"
settings = { n = 6.0 }

[[attempt]]
name = "less"
fails = ["n"]
```

### Goal

To see.

### Predict

How near? With n = 4 it is {measured:d:1}.

1. Near.
   > No: {measured:d}.
2. Far.
   > Yes, {measured:d}.

### Do

Run.

### Observe

It was {measured:d} at {setting:dm}.

### Explain

Because $x$.

### Challenge

Raise n.

### Hints

1. One.
2. Two.
3. Three.

## Second

```duet
id = "second"
input = "yours"
seconds = 1.0

[[measure]]
name = "smallest_distance"
```

### Goal

Move it.

### Do

Move the ball.
"""


@cache
def our_book(language: str = "en") -> LessonBook:
    return load_lessons(language=language)  # pyright: ignore[reportArgumentType]


def book_of(folder: Path, text: str = SMALL, name: str = "01-small.md") -> LessonBook:
    (folder / name).write_text(text, encoding="utf-8")
    return load_lessons(folder)


def to_challenge(walk: Walkthrough) -> None:
    if walk.locked:
        walk.choose(0)
    while walk.phase is not Phase.CHALLENGE:
        assert walk.next()


def run_out(walk: Walkthrough) -> None:
    walk.observe(simulated(walk.setup))


def much_done(own: str = "", right: bool = True) -> tuple[Lesson, int, StepProgress]:
    """A finished step with a question, a drawing and a challenge. `own`: the student's words and reason."""
    book = our_book()
    lesson = book.lessons[book.index("lambda")]
    index, step = next(
        (i, step) for i, step in enumerate(lesson.steps) if step.question and step.drawing and step.challenge
    )
    assert step.question is not None
    choice = step.question.right if right else (step.question.right + 1) % len(step.question.choices)
    judgement = Judgement("d", True, LazyText("d ≥ {limit}", limit="150 mm"), 0.2)
    done = StepProgress(
        choice, reference(step, step.setup), attempts=3, passed=True, last=Attempt.of([judgement])
    )
    done.words, done.because, done.drawing = own, own, (0.5,) * COLUMNS
    return lesson, index, done


class HasSession(Protocol):
    """A visitor or its substitute in a test."""

    @property
    def session(self) -> Session: ...


def lessons_of(visitor: HasSession) -> LessonSession:
    return visitor.session.parts.of(LessonSession)


def lessons_in(session: Session, book: LessonBook) -> LessonSession:
    """Lessons of a session without a server; they decide in its frames."""
    lessons = session.parts.of(LessonSession)
    lessons.begin_with(book, "en")
    return lessons


def lesson_in(record: VisitorRecord | None) -> SavedLesson | None:
    return None if record is None else part_of(record, LessonSession.name, SavedLesson)


def progress_in(record: VisitorRecord | None) -> Progress:
    saved = lesson_in(record)
    return Progress() if saved is None else from_json(saved.progress)


def opens_lesson(record: VisitorRecord | None) -> bool:
    saved = lesson_in(record)
    return saved is not None and saved.open


def saved_at(query: Mapping[str, str], session: Session) -> VisitorRecord:
    """Record of a session opened by a link, without its run."""
    return VisitorRecord(query, Settings(), None, session.parts.saved(), session.parts.recordings())
