"""Actions of a student in a lesson; steps have ids."""

from typing import Literal

from app.plots.curve_chart import Curve
from app.session.actions import Action


class LessonAction(Action):
    """What a lesson does."""


class Enter(LessonAction):
    """Open a lesson (0-based), also from outside the lessons."""

    lesson: int


class Choose(LessonAction):
    """Choose an answer (0-based)."""

    answer: int


class Draw(LessonAction):
    """Draw a curve; () clears it."""

    lesson: str
    step: str
    curve: Curve


class Guess(LessonAction):
    """Guess d on the line of contact [m]."""

    lesson: str
    step: str
    distance: float


class GoTo(LessonAction):
    """Open a step (0-based); None for the current lesson, or the student's step in it."""

    lesson: int | None
    step: int | None


class SayNumber(LessonAction, newest_by=("lesson", "step", "index")):
    """Enter forecast `index` (0-based) of a challenge; None clears it."""

    lesson: str
    step: str
    index: int
    number: float | None


class Write(LessonAction, newest_by=("lesson", "step")):
    """Keep the student's own text about a step."""

    lesson: str
    step: str
    words: str


class GiveReason(LessonAction, newest_by=("lesson", "step")):
    """Give a reason for a prediction."""

    lesson: str
    step: str
    reason: str


class Press(LessonAction, newest_by=("what",)):
    """Press a button of the lessons, or its key.

    Attributes:
        what: "reset" restarts the step, "again" the run. "next" first fast-forwards a measured run. "why"
            shows the run that explains a wrong answer, "curve" the run with the drawn λ(d).
    """

    what: Literal["list", "next", "back", "reset", "again", "run", "why", "curve", "hint", "check", "leave"]
