"""Actions of a student in a lesson, as typed values."""

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
    """Draw a curve in a step, named by ids; () clears it."""

    lesson: str
    step: str
    curve: Curve


class Guess(LessonAction):
    """Guess d [m] on the line of contact in a step, named by ids."""

    lesson: str
    step: str
    distance: float


class GoTo(LessonAction):
    """Open a step (0-based); None for the current lesson, or for the student's step in it."""

    lesson: int | None
    step: int | None


class SayNumber(LessonAction, newest_by=("lesson", "step", "index")):
    """Enter forecast `index` (0-based) of a challenge; None clears it."""

    lesson: str
    step: str
    index: int
    number: float | None


class Write(LessonAction, newest_by=("lesson", "step")):
    """Keep the student's own text about a step, named by ids."""

    lesson: str
    step: str
    words: str


class GiveReason(LessonAction, newest_by=("lesson", "step")):
    """Give a reason for the prediction in a step, named by ids."""

    lesson: str
    step: str
    reason: str


class Press(LessonAction, newest_by=("what",)):
    """Press a button of the lessons, or its key.

    Attributes:
        what: show or close the list of lessons (list); next phase or step, after fast-forwarding a measured
            run (next); previous one (back); restart the step (reset) or the run (again); start, pause or
            continue the run (run); show the run that explains a wrong answer (why), or the run with the drawn
            λ(d) (curve); next hint (hint); check the challenge (check); close the lessons (leave).
    """

    what: Literal["list", "next", "back", "reset", "again", "run", "why", "curve", "hint", "check", "leave"]
