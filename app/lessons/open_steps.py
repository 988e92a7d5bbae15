"""The steps of one lesson that a teacher has opened to those who work alone."""

import re
from typing import Final, NamedTuple

from app.i18n.speaking import N_
from app.lessons.lesson import Lesson
from controllers.errors import BadSetting, LazyText

LONGEST: Final = 20
"""Characters in which a teacher says which steps."""


class OpenSteps(NamedTuple):
    """The steps that are open. `lesson`: its id; `number`: the lesson's; `first`, `last`: from 0."""

    lesson: str
    number: int
    first: int
    last: int

    def allows(self, lesson: str, step: int) -> bool:
        """Return whether a step is open."""
        return lesson == self.lesson and self.first <= step <= self.last

    def nearest(self, lesson: str, step: int) -> int:
        """Return the open step that is nearest to another one."""
        return self.first if lesson != self.lesson else min(max(step, self.first), self.last)

    @property
    def words(self) -> LazyText:
        """Return which steps are open, for a student and the teacher."""
        if self.first == self.last:
            return LazyText(N_("Lesson {lesson}: step {step} only."), lesson=self.number, step=self.first + 1)
        parts = {"lesson": self.number, "first": self.first + 1, "last": self.last + 1}
        return LazyText(N_("Lesson {lesson}: steps {first} to {last} only."), **parts)


def open_steps_from_text(text: str, lesson: Lesson) -> OpenSteps | None:
    """Return the pace that a teacher types as 2 or 2-3; None for an empty text: every step is open.

    Raises:
        BadSetting: the text says no steps of the lesson.
    """
    if not text.strip():
        return None
    found = re.fullmatch(r"\s*(\d{1,2})\s*(?:[-–]\s*(\d{1,2})?)?\s*", text[:LONGEST], re.ASCII)
    count = len(lesson.steps)
    first, last = (int(found[1]), int(found[2] or found[1])) if found else (0, 0)
    if not 1 <= first <= last <= count:
        if count == 1:
            raise BadSetting(N_("This lesson has one step: write 1, or nothing."))
        raise BadSetting("Steps are written 2 or 2-3; this lesson has 1 to {count}. Nothing opens all.", count=count)
    return OpenSteps(lesson.id, lesson.number, first - 1, last - 1)
