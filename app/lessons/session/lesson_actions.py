"""What a student can ask a lesson for, as typed values."""

from dataclasses import dataclass

from app.plots.curve_chart import Curve


@dataclass(frozen=True)
class Choose:
    """Predict an answer, from 0."""

    answer: int


@dataclass(frozen=True)
class Draw:
    """Predict a curve in the step of a lesson, by their names; () takes it back."""

    lesson: str
    step: str
    curve: Curve


@dataclass(frozen=True)
class Guess:
    """Guess d [m] on the line of contact in the step of a lesson, by their names."""

    lesson: str
    step: str
    distance: float


@dataclass(frozen=True)
class GoTo:
    """Open a step of a lesson, both from 0."""

    lesson: int
    step: int


@dataclass(frozen=True)
class ListLessons:
    """Show the list of lessons, or close it."""


@dataclass(frozen=True)
class GoOn:
    """Go to the next phase or step; a run that is to be measured runs to its end first."""


@dataclass(frozen=True)
class GoBack:
    """Go to the phase or step before."""


@dataclass(frozen=True)
class ResetStep:
    """Begin the step from its first phase."""


@dataclass(frozen=True)
class RunAgain:
    """Begin the present run again."""


@dataclass(frozen=True)
class StartOrPause:
    """Start the run, pause it, or go on."""


@dataclass(frozen=True)
class ShowWhy:
    """Show the run that explains a wrong answer."""


@dataclass(frozen=True)
class ShowHint:
    """Show the next hint of the challenge."""


@dataclass(frozen=True)
class Check:
    """Check the challenge."""


@dataclass(frozen=True)
class Leave:
    """Close the lessons."""


LessonAction = (
    Choose
    | Draw
    | Guess
    | GoTo
    | ListLessons
    | GoOn
    | GoBack
    | ResetStep
    | RunAgain
    | StartOrPause
    | ShowWhy
    | ShowHint
    | Check
    | Leave
)
