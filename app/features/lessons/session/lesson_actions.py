"""What a student can ask a lesson for, as typed values."""

from typing import Literal

from app.plots.curve_chart import Curve
from app.session.actions import Action


class LessonAction(Action):
    """What a lesson does."""


class Enter(LessonAction):
    """Open a lesson, from 0, outside the lessons too."""

    lesson: int


class Choose(LessonAction):
    """Predict an answer, from 0."""

    answer: int


class Draw(LessonAction):
    """Predict a curve in the step of a lesson, by their names; () takes it back."""

    lesson: str
    step: str
    curve: Curve


class Guess(LessonAction):
    """Guess d [m] on the line of contact in the step of a lesson, by their names."""

    lesson: str
    step: str
    distance: float


class GoTo(LessonAction):
    """Open a step of a lesson, both from 0; None for the present lesson, or for the step in which the student was."""

    lesson: int | None
    step: int | None


class SayNumber(LessonAction, newest_by=("lesson", "step", "index")):
    """Say a number, from 0, that the challenge in the step of a lesson asks for, by their names; None takes it back."""

    lesson: str
    step: str
    index: int
    number: float | None


class Write(LessonAction, newest_by=("lesson", "step")):
    """Keep the student's own words about the step of a lesson, by their names."""

    lesson: str
    step: str
    words: str


class GiveReason(LessonAction, newest_by=("lesson", "step")):
    """Give a reason for the prediction in the step of a lesson, by their names."""

    lesson: str
    step: str
    reason: str


class Press(LessonAction, newest_by=("what",)):
    """Press a button of the lessons, or its key.

    Attributes:
        what: show the list of lessons, or close it (list); go to the next phase or step, where a run that is to be measured runs to its
            end first (next), or to the one before (back); begin the step from its first phase (reset), or the present run (again); start
            the run, pause it, or go on (run); show the run that explains a wrong answer (why), or run the step once more with the λ(d)
            that the student drew (curve); show the next hint of the challenge (hint), or check it (check); close the lessons (leave).
    """

    what: Literal["list", "next", "back", "reset", "again", "run", "why", "curve", "hint", "check", "leave"]
