"""The list of lessons: what each one promises, and how far the student has come in it."""

from collections.abc import Iterator
from dataclasses import dataclass

from app.lessons.bookmark import is_finished
from app.lessons.lesson import Lesson, LessonBook
from app.lessons.walkthrough import Walkthrough


@dataclass(frozen=True)
class LessonEntry:
    """A line of the list.

    Attributes:
        lesson: in the reader's language.
        finished: of each step, whether it is.
        here: whether the student was in this lesson last.
        step: at which it opens, from 0.
    """

    lesson: Lesson
    finished: tuple[bool, ...]
    here: bool
    step: int


def lesson_entries(walk: Walkthrough, book: LessonBook | None = None) -> Iterator[LessonEntry]:
    """Yield every lesson. `book`: the lessons in the reader's language; None for those of `walk`."""
    begun = walk.begun or walk.step is not walk.book.lessons[walk.book.first].steps[0]
    for lesson in (book or walk.book).lessons:
        finished = tuple(is_finished(step, walk.done_in(lesson.id, step.id)) for step in lesson.steps)
        here = begun and lesson.id == walk.lesson.id
        step = walk.step_index if here else finished.index(False) if False in finished else 0
        yield LessonEntry(lesson, finished, here, step)
