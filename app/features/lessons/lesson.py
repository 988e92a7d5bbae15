"""What a lesson is, as data: steps, questions, runs, measurements, challenges. `loading` makes it from Markdown files."""

import re
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Final, Literal

from app.features.lessons.runs import Pairs, Setup
from app.features.measures.quantities.quantity import UNITS, Value, shown_value, significant_digits
from app.features.measures.room_places import Start
from app.plots.drawing_axes import Drawing
from app.settings import TRANSLATIONS, Language
from controllers.errors import BadSetting, LazyText, NumberText
from scenes.laws import LEVER_LAW

LessonCamera = Literal["room", "hand", "elbow", "between", "top"]
"""From where one looks: at the whole, close to the hand or the elbow, at the line between the arms, from above."""

AT_ONCE: Final = ("curve", "laws", "stability")
"""Plots that say what a law does before anything has run."""

MOST_CHOICES: Final = 6
MOST_FORECASTS: Final = 4


@dataclass(frozen=True)
class Compared:
    """A further run that a measurement is compared with: the settings that differ, and a start of its own if it has one."""

    changes: Pairs
    start: Start | None = None

    def setup(self, base: Setup) -> Setup:
        setup = base.with_changes(self.changes)
        return setup if self.start is None else replace(setup, start=self.start)


@dataclass(frozen=True)
class Measurement:
    """A number that is measured in a run.

    Attributes:
        id: by which a text names it.
        name: of the function, see `measures`.
        parameters: of the function.
        unit: in which it is shown, see `UNITS`.
        digits: after the point.
        compare: further runs in which the same is measured.
        text_only: whether only a text names it, and it does not stand among what was measured.
    """

    id: str
    name: str
    parameters: Pairs
    unit: str
    digits: int
    compare: tuple[Compared, ...] = ()
    text_only: bool = False

    def text(self, value: Value) -> str:
        """Return a value as it is read, with two significant digits and its unit; of less than its digits can say, only that."""
        said = shown_value(value, self.unit, significant_digits(value, self.unit, self.digits))
        if value is None or value <= 0.0 or not self.digits or re.search("[1-9∞]", said.split()[0]):
            return said
        return NumberText("< " + shown_value(10.0**-self.digits / UNITS[self.unit].factor, self.unit, self.digits))


@dataclass(frozen=True)
class Choice:
    """A possible answer.

    Attributes:
        reply: what is said to it when the outcome is known.
        why: a run that shows why it is wrong; None for the right one, and where the step's own run shows it.
        otherwise: whether that run shows the case in which the answer would be right, rather than that it is wrong here.
        same: whether it is the point that this run gives the same number as that of the question.
    """

    text: str
    reply: str
    why: Setup | None = None
    otherwise: bool = False
    same: bool = False


Expectation = float | tuple[float, float]
"""What the first measurement of a step would be if a choice were right: the nearest number wins, or the range that holds it."""


@dataclass(frozen=True)
class Question:
    """What is to be predicted.

    Attributes:
        choices: two to six.
        right: index of the right one.
        expects: one for each choice, or none: then the outcome does not decide between them by itself.
        ratio: whether it is about the first measurement over its first comparison.
    """

    text: str
    choices: tuple[Choice, ...]
    right: int
    expects: tuple[Expectation, ...] = ()
    ratio: bool = False

    def answer(self, values: tuple[Value, ...]) -> Value:
        """Return the deciding number: the first measurement, or its ratio to the first comparison; None if the run does not tell."""
        if not self.ratio:
            return values[0] if values else None
        if len(values) < 2 or values[0] is None or not values[1]:
            return None
        return values[0] / values[1]

    def supported(self, value: Value) -> int | None:
        """Return the index of the choice that a measured value speaks for; None if it speaks for none."""
        if value is None or value != value or not self.expects:
            return None
        ranges = [e for e in self.expects if isinstance(e, tuple)]
        if ranges:
            return next((i for i, e in enumerate(self.expects) if isinstance(e, tuple) and e[0] <= value <= e[1]), None)
        numbers = [float(e) for e in self.expects if not isinstance(e, tuple)]
        return min(range(len(numbers)), key=lambda i: abs(numbers[i] - value))


@dataclass(frozen=True)
class Criterion:
    """An inequality that a challenge asks for: low ≤ measured ≤ high, in SI units; None where there is no bound."""

    measurement: Measurement
    low: float | None = None
    high: float | None = None


@dataclass(frozen=True)
class Forecast:
    """A number that the student says beforehand.

    Attributes:
        measurement: what is measured then.
        changes: settings that differ from the challenge's run.
        within: largest relative error.
    """

    measurement: Measurement
    changes: Pairs
    within: float


@dataclass(frozen=True)
class Challenge:
    """What the software checks.

    Attributes:
        setup: with what it begins; the student may change the settings.
        criteria: all must hold.
        forecasts: all must be near enough.
        custom_law: whether a custom law is to pass the six tests of `app.features.custom_law.trials`.
        null_motions: whether the student has a slider for each of the arm's motions that leave the hand where it is.
        search: key of the setting that the student looks for by trying, so that the tries are plotted; "" if none is.
        keep: name under which the student's motion is kept for a later step; "" if it is not.
        best_of: how many pushes count of a duel; 0 for no duel. The nearest one is kept.
    """

    text: str
    setup: Setup
    criteria: tuple[Criterion, ...]
    forecasts: tuple[Forecast, ...]
    custom_law: bool
    keep: str
    null_motions: bool = False
    search: str = ""
    best_of: int = 0


@dataclass(frozen=True)
class Trial:
    """A way to try a challenge, declared with the lesson so that `check` can walk it.

    Attributes:
        forecasts: what is said beforehand, in the order of the challenge's; a text names a measurement that gives the number.
        law: name of the law that stands in for the custom law.
        fails: identities of the inequalities that are missed, all of them; empty if it passes.
    """

    name: str
    setup: Setup
    forecasts: tuple[float | str, ...]
    law: str
    fails: tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class Step:
    """One thing to learn.

    Attributes:
        id: unique in its lesson.
        title, goal, do, observe, explain: texts in Markdown with LaTeX; observe and explain may be "".
        question: None if there is nothing to predict.
        measurements: what is measured in the run; the first one answers the question.
        challenge: None if there is none.
        hints: three, or none.
        trials: declared ways to try the challenge.
        camera: from where one looks.
        plots: at most three.
        numbers: at most three live measurements.
        drawing: a curve to be drawn before the question is answered; None if there is none.
        marks: angles by which the elbow's place at the start is turned about the line from shoulder to wrist [rad]: marks to touch.
        concept: whether the question is asked without a run; what the step measures comes from the software's own run.
        belief: what the wrong answers have in common, for the teacher and for afterwards; "" if it is not named.
        asked: in a test that is asked twice: for the first time, when nothing is said to the answer, or for the last time; "" elsewhere.
        controls: keys of the settings that stand in the lesson's own panel while the student may change them.
        number: where it stands in its file, from 1; a playlist may show it elsewhere.
    """

    id: str
    title: str
    goal: str = ""
    do: str = ""
    observe: str = ""
    explain: str = ""
    setup: Setup
    question: Question | None
    measurements: tuple[Measurement, ...]
    challenge: Challenge | None
    hints: tuple[str, ...]
    trials: tuple[Trial, ...]
    camera: LessonCamera
    plots: tuple[str, ...]
    numbers: tuple[Measurement, ...]
    marks: tuple[float, ...]
    drawing: Drawing | None = None
    concept: bool = False
    belief: str = ""
    asked: Literal["", "first", "last"] = ""
    controls: tuple[str, ...] = ()
    number: int = 1

    @property
    def yours(self) -> bool:
        return self.setup.input.kind == "yours"

    @property
    def at_lever(self) -> bool:
        """True if the student is λ in the step's run."""
        return self.setup.run.law.law == LEVER_LAW


@dataclass(frozen=True)
class Lesson:
    """A lesson.

    Attributes:
        id: name of its file without number and ending, unique in its folder.
        number: where it stands.
        file: name of its file.
        language: of its texts.
        equations: of the paper, as a person reads them, such as "1–6".
        minutes: how long it takes.
        promise, learned: what a student will be able to say, and what they have learned at the end; "" if the file does not say it.
        steps: at least one.
        again: title of a test when it is asked for the last time; "" for what is no test.
    """

    id: str
    number: int
    file: str
    language: Language
    title: str
    goal: str
    equations: str
    minutes: int
    promise: str
    learned: str
    steps: tuple[Step, ...]
    again: str = ""

    @property
    def asked(self) -> Literal["", "first", "last"]:
        """Return which time a test is asked."""
        return self.steps[0].asked


LAST: Final = "_last"
"""Follows the name of a test when it is asked for the last time."""


@dataclass(frozen=True)
class LessonProblem:
    """What is wrong with a file, and where. `line`: from 1; 0 for a whole folder."""

    file: str
    line: int
    message: str

    def __str__(self) -> str:
        if self.line == 0:
            return f"{self.file}: {self.message}"
        return LazyText("{name}, line {line}: {what}", name=self.file, line=self.line, what=self.message)


@dataclass(frozen=True)
class LessonBook:
    """All lessons that could be read, in order, and what was wrong with the others.

    Attributes:
        translated: returns the same book in another language; None where there is none.
    """

    lessons: tuple[Lesson, ...]
    problems: tuple[LessonProblem, ...]
    translated: "Callable[[Language], LessonBook] | None" = field(default=None, compare=False, repr=False)

    def in_language(self, language: Language) -> "LessonBook":
        """Return the same lessons with the texts that lie beside them in another language; what is not translated stays English."""
        return self if self.translated is None or language not in TRANSLATIONS else self.translated(language)

    @property
    def first(self) -> int:
        """First place of a student: the first lesson that is not a test."""
        return next((i for i, lesson in enumerate(self.lessons) if not lesson.asked), 0)

    def index(self, name: object) -> int:
        """Place of a lesson. `name`: its id, or its number.

        Raises:
            BadSetting: there is none.
        """
        for i, lesson in enumerate(self.lessons):
            if name in (lesson.id, lesson.number, str(lesson.number)):
                return i
        names = ", ".join(f"{lesson.number} {lesson.id}" for lesson in self.lessons) or "none"
        raise BadSetting("There is no lesson {id}; choose from {names}.", id=repr(name)[:42], names=names)


NO_LESSONS: Final = LessonBook((), ())
"""An empty book."""
