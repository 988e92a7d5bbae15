"""Lessons as data, read by `loading`."""

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

AT_ONCE: Final = ("curve", "laws", "stability")

MOST_CHOICES: Final = 6
MOST_FORECASTS: Final = 4


@dataclass(frozen=True)
class Compared:
    """A further run. `start`: None for that of the base."""

    changes: Pairs
    start: Start | None = None

    def setup(self, base: Setup) -> Setup:
        setup = base.with_changes(self.changes)
        return setup if self.start is None else replace(setup, start=self.start)


@dataclass(frozen=True)
class Measurement:
    """A number measured in a run.

    Attributes:
        name, parameters: function of `measures` and its arguments.
        unit: key of `UNITS`.
        text_only: true if the list of measured values omits it.
    """

    id: str
    name: str
    parameters: Pairs
    unit: str
    digits: int
    compare: tuple[Compared, ...] = ()
    text_only: bool = False

    def text(self, value: Value) -> str:
        """Value with two significant digits and its unit, or "< smallest shown value"."""
        said = shown_value(value, self.unit, significant_digits(value, self.unit, self.digits))
        if value is None or value <= 0.0 or not self.digits or re.search("[1-9∞]", said.split()[0]):
            return said
        return NumberText(
            "< " + shown_value(10.0**-self.digits / UNITS[self.unit].factor, self.unit, self.digits)
        )


@dataclass(frozen=True)
class Choice:
    """A possible answer.

    Attributes:
        why: run that shows why it is wrong; None if right, or if the step's run shows it.
        otherwise: the answer would be right in that run.
        same: that run must give the question's number.
    """

    text: str
    reply: str
    why: Setup | None = None
    otherwise: bool = False
    same: bool = False


Expectation = float | tuple[float, float]
"""First measurement if a choice were right: a number (the nearest wins) or a range."""


@dataclass(frozen=True)
class Question:
    """A prediction.

    Attributes:
        expects: one for each choice; empty if the outcome does not decide.
        ratio: true if it asks for the first measurement over its first comparison.
    """

    text: str
    choices: tuple[Choice, ...]
    right: int
    expects: tuple[Expectation, ...] = ()
    ratio: bool = False

    def answer(self, values: tuple[Value, ...]) -> Value:
        if not self.ratio:
            return values[0] if values else None
        if len(values) < 2 or values[0] is None or not values[1]:
            return None
        return values[0] / values[1]

    def supported(self, value: Value) -> int | None:
        if value is None or value != value or not self.expects:
            return None
        ranges = [e for e in self.expects if isinstance(e, tuple)]
        if ranges:
            return next(
                (i for i, e in enumerate(self.expects) if isinstance(e, tuple) and e[0] <= value <= e[1]),
                None,
            )
        numbers = [float(e) for e in self.expects if not isinstance(e, tuple)]
        return min(range(len(numbers)), key=lambda i: abs(numbers[i] - value))


@dataclass(frozen=True)
class Criterion:
    """low ≤ measured ≤ high [SI]; None for no bound."""

    measurement: Measurement
    low: float | None = None
    high: float | None = None


@dataclass(frozen=True)
class Forecast:
    """A number to predict. `within`: largest relative error."""

    measurement: Measurement
    changes: Pairs
    within: float


@dataclass(frozen=True)
class Challenge:
    """A task that the software checks.

    Attributes:
        criteria, forecasts: all must be met.
        custom_law: a custom law must pass the six tests of `app.features.custom_law.trials`.
        null_motions: a slider for each null-space motion.
        search: key of the setting to search, or "".
        keep: name of the student's motion for a later step, or "".
        best_of: pushes of a duel, of which the nearest counts; 0 for no duel.
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
    """A declared attempt, for `check`.

    Attributes:
        forecasts: in order; a text names the measurement that gives the number.
        law: replaces the custom law.
        fails: ids of all missed criteria.
    """

    name: str
    setup: Setup
    forecasts: tuple[float | str, ...]
    law: str
    fails: tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class Step:
    """A step; its texts are Markdown with LaTeX.

    Attributes:
        id: unique in its lesson.
        measurements: the first one answers the question.
        marks: elbow angles to touch, about the line from shoulder to wrist, relative to the start [rad].
        concept: a question without a run; the reference run gives the measurements.
        belief: common idea of the wrong answers, for the teacher, or "".
        asked: in a test, the first time (without replies) or the last time; else "".
        controls: keys of settings in the lesson's panel.
        number: 1-based place in the file.
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
        return self.setup.run.law.law == LEVER_LAW


@dataclass(frozen=True)
class Lesson:
    """A lesson.

    Attributes:
        id: file name without number and extension.
        equations: of the paper, such as "1–6".
        promise, learned: first and last sentences, or "".
        again: title of a test in its last round; else "".
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
        return self.steps[0].asked


LAST: Final = "_last"
"""Suffix of a test's id in its last round."""


@dataclass(frozen=True)
class LessonProblem:
    """A fault of a file. `line`: 1-based; 0 for a whole folder."""

    file: str
    line: int
    message: str

    def __str__(self) -> str:
        if self.line == 0:
            return f"{self.file}: {self.message}"
        return LazyText("{name}, line {line}: {what}", name=self.file, line=self.line, what=self.message)


@dataclass(frozen=True)
class LessonBook:
    """Readable lessons, and faults of the others."""

    lessons: tuple[Lesson, ...]
    problems: tuple[LessonProblem, ...]
    translated: "Callable[[Language], LessonBook] | None" = field(default=None, compare=False, repr=False)

    def in_language(self, language: Language) -> "LessonBook":
        return self if self.translated is None or language not in TRANSLATIONS else self.translated(language)

    @property
    def first(self) -> int:
        return next((i for i, lesson in enumerate(self.lessons) if not lesson.asked), 0)

    def index(self, name: object) -> int:
        """Index of a lesson.

        `name`: id or number.

        Raises:
            BadSetting: unknown lesson.
        """
        for i, lesson in enumerate(self.lessons):
            if name in (lesson.id, lesson.number, str(lesson.number)):
                return i
        names = ", ".join(f"{lesson.number} {lesson.id}" for lesson in self.lessons) or "none"
        raise BadSetting("There is no lesson {id}; choose from {names}.", id=repr(name)[:42], names=names)


NO_LESSONS: Final = LessonBook((), ())
