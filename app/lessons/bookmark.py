"""Where in a book of lessons a student is: lesson and step, one after the other."""

from typing import NamedTuple

from app.lessons.lesson import Lesson, LessonBook, Step
from controllers.errors import BadSetting


class Bookmark(NamedTuple):
    """A step of a book.

    Attributes:
        book: with at least one lesson.
        lesson_index, step_index: from 0.
    """

    book: LessonBook
    lesson_index: int = 0
    step_index: int = 0

    @property
    def lesson(self) -> Lesson:
        return self.book.lessons[self.lesson_index]

    @property
    def step(self) -> Step:
        return self.lesson.steps[self.step_index]

    def after(self) -> "Bookmark | None":
        """Return the next step, perhaps of the next lesson; None at the end of the book."""
        if self.step_index + 1 < len(self.lesson.steps):
            return self._replace(step_index=self.step_index + 1)
        if self.lesson_index + 1 < len(self.book.lessons):
            return self._replace(lesson_index=self.lesson_index + 1, step_index=0)
        return None

    def before(self) -> "Bookmark | None":
        """Return the step before, perhaps of the lesson before; None at the beginning of the book."""
        if self.step_index > 0:
            return self._replace(step_index=self.step_index - 1)
        if self.lesson_index > 0:
            last = len(self.book.lessons[self.lesson_index - 1].steps) - 1
            return self._replace(lesson_index=self.lesson_index - 1, step_index=last)
        return None

    def at(self, lesson: str | int, step: int) -> "Bookmark":
        """Return a step. `lesson`: its id, or its place from 0; `step`: from 0.

        Raises:
            BadSetting: there is no such lesson or step.
        """
        index = self.book.index(lesson) if isinstance(lesson, str) else lesson
        if not 0 <= index < len(self.book.lessons):
            most = len(self.book.lessons)
            raise BadSetting("There is no lesson {number}; give a number from 1 to {most}.", number=index + 1, most=most)
        steps = self.book.lessons[index].steps
        if not 0 <= step < len(steps):
            name = self.book.lessons[index].id
            raise BadSetting("There is no step {step} in {name}; give 1 to {most}.", step=step + 1, name=name, most=len(steps))
        return self._replace(lesson_index=index, step_index=step)

    def of(self, lesson: str, step: str) -> "Bookmark":
        """Return the step with an id in the lesson with an id; the first one of the book if they are not there."""
        for i, one in enumerate(self.book.lessons):
            for j, other in enumerate(one.steps):
                if (one.id, other.id) == (lesson, step):
                    return Bookmark(self.book, i, j)
        return Bookmark(self.book)
