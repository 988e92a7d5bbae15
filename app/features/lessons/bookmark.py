"""A student's place, and a teacher's open steps."""

import re
from dataclasses import replace
from enum import StrEnum
from typing import Final, Literal, NamedTuple

from app.features.lessons.lesson import Lesson, LessonBook, Step
from app.features.lessons.outcomes import StepOutcome
from app.features.lessons.progress import StepProgress
from app.i18n.speaking import N_
from app.plots.drawing_axes import checked_curve
from controllers.errors import BadSetting, LazyText


class Bookmark(NamedTuple):
    """A step of a book; indices are 0-based."""

    book: LessonBook
    lesson_index: int = 0
    step_index: int = 0

    @property
    def lesson(self) -> Lesson:
        return self.book.lessons[self.lesson_index]

    @property
    def step(self) -> Step:
        return self.lesson.steps[self.step_index]

    def next_to(self, way: Literal[-1, 1]) -> "Bookmark | None":
        """Next or previous step; None beyond the book's ends."""
        places = [(i, j) for i, lesson in enumerate(self.book.lessons) for j in range(len(lesson.steps))]
        place = places.index((self.lesson_index, self.step_index)) + way
        return Bookmark(self.book, *places[place]) if 0 <= place < len(places) else None

    def at(self, lesson: str | int, step: int) -> "Bookmark":
        """Another step. `lesson`: id or 0-based index; `step`: 0-based.

        Raises:
            BadSetting: unknown lesson or step.
        """
        index = self.book.index(lesson) if isinstance(lesson, str) else lesson
        if not 0 <= index < len(self.book.lessons):
            most = len(self.book.lessons)
            raise BadSetting(
                "There is no lesson {number}; give a number from 1 to {most}.", number=index + 1, most=most
            )
        steps = self.book.lessons[index].steps
        if not 0 <= step < len(steps):
            raise BadSetting(
                "There is no step {step} in lesson {number}; give 1 to {most}.",
                step=step + 1,
                number=self.book.lessons[index].number,
                most=len(steps),
            )
        return self._replace(lesson_index=index, step_index=step)

    def of(self, lesson: str, step: str) -> "Bookmark":
        """Step with these ids; the book's first step if unknown."""
        for i, one in enumerate(self.book.lessons):
            for j, other in enumerate(one.steps):
                if (one.id, other.id) == (lesson, step):
                    return Bookmark(self.book, i, j)
        return Bookmark(self.book, self.book.first)


class Phase(StrEnum):
    PREDICT = "predict"
    DO = "do"
    OBSERVE = "observe"
    EXPLAIN = "explain"
    CHALLENGE = "challenge"


def phases_of(step: Step) -> tuple[Phase, ...]:
    told = step.asked != "first"
    has = {
        Phase.PREDICT: step.question is not None,
        Phase.DO: not step.concept,
        Phase.OBSERVE: told and bool(step.concept or step.measurements or step.observe),
        Phase.EXPLAIN: told and step.explain != "",
        Phase.CHALLENGE: step.challenge is not None,
    }
    return tuple(phase for phase, there in has.items() if there)


def first_phase(step: Step, done: StepProgress) -> Phase:
    phases = phases_of(step)
    return Phase.DO if phases[0] is Phase.PREDICT and done.predicted and not step.concept else phases[0]


def is_finished(step: Step, done: StepProgress) -> bool:
    if step.challenge is not None or step.asked == "first":
        return done.passed if step.challenge is not None else done.predicted
    return done.outcome is not None or (not step.measurements and not step.concept and not done.untouched)


def furthest_phase(step: Step, done: StepProgress) -> Phase:
    phases = phases_of(step)
    if done.outcome is not None or (not step.measurements and not step.concept and not done.untouched):
        return phases[-1]
    return first_phase(step, done)


def fitting(step: Step, done: StepProgress) -> StepProgress:
    """Progress adapted to a step that may have changed."""
    question, fitting = step.question, replace(done)
    if question is None or (done.choice is not None and done.choice >= len(question.choices)):
        fitting.choice = None
    widths = [1 + len(m.compare) for m in step.measurements]
    for name in ("outcome", "why"):
        outcome: StepOutcome | None = getattr(done, name)
        if outcome is not None and [len(row) for row in outcome.values] != widths:
            setattr(fitting, name, None)
    fitting.drawing = (checked_curve(step.drawing, done.drawing) or ()) if step.drawing is not None else ()
    if question is not None and not fitting.predicted:
        fitting.outcome = fitting.why = None
    fitting.hints = min(done.hints, len(step.hints))
    return fitting


LONGEST_PACE: Final = 20
"""Longest text [characters]."""


class OpenSteps(NamedTuple):
    """The open steps. `lesson`: id; `first`, `last`: 0-based."""

    lesson: str
    number: int
    first: int
    last: int

    def allows(self, lesson: str, step: int) -> bool:
        return lesson == self.lesson and self.first <= step <= self.last

    def nearest(self, lesson: str, step: int) -> int:
        return self.first if lesson != self.lesson else min(max(step, self.first), self.last)

    @property
    def words(self) -> LazyText:
        if self.first == self.last:
            return LazyText(N_("Lesson {lesson}: step {step} only."), lesson=self.number, step=self.first + 1)
        parts = {"lesson": self.number, "first": self.first + 1, "last": self.last + 1}
        return LazyText(N_("Lesson {lesson}: steps {first} to {last} only."), **parts)


def open_steps_from_text(text: str, lesson: Lesson) -> OpenSteps | None:
    """Parse the teacher's text, such as 2 or 2-3; None (all open) if empty.

    Raises:
        BadSetting: not steps of the lesson.
    """
    if not text.strip():
        return None
    found = re.fullmatch(r"\s*(\d{1,2})\s*(?:[-–]\s*(\d{1,2})?)?\s*", text[:LONGEST_PACE], re.ASCII)
    count = len(lesson.steps)
    first, last = (int(found[1]), int(found[2] or found[1])) if found else (0, 0)
    if not 1 <= first <= last <= count:
        if count == 1:
            raise BadSetting(N_("This lesson has one step: write 1, or nothing."))
        raise BadSetting(
            "Steps are written 2 or 2-3; this lesson has 1 to {count}. Nothing opens all.", count=count
        )
    return OpenSteps(lesson.id, lesson.number, first - 1, last - 1)
