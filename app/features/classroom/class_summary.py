"""Report of a class as data."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from app.features.lessons.lesson import Lesson
from app.features.lessons.tally import QuestionId, Switch, Tally


@dataclass(frozen=True)
class AskedQuestion:
    """An answered question. `switches`: from the first round to the last one; () for one round."""

    question: QuestionId
    rounds: tuple[Tally, ...]
    switches: tuple[Switch, ...] = ()


@dataclass(frozen=True)
class HandIn:
    """One student's hand-in.

    Attributes:
        name: may be "".
        progress: JSON, see `app.features.lessons.progress.to_json`.
        answers: in every round, or None.
    """

    name: str
    progress: str
    answers: Mapping[QuestionId, tuple[int | None, ...]] = field(default_factory=dict)


@dataclass(frozen=True)
class ClassSummary:
    """Report of a class; only `hand_ins` has names.

    Attributes:
        saved: [s since 1970].
        asked: in the order of the first answers.
        passed: number of students.
        hand_ins: by name, unnamed ones last.
        paired: question of a repeated test → answers before and after (0-based).
    """

    saved: float
    students: int
    asked: tuple[AskedQuestion, ...]
    passed: Mapping[QuestionId, int] = field(default_factory=dict)
    hand_ins: tuple[HandIn, ...] = ()
    paired: Mapping[QuestionId, tuple[tuple[int, int], ...]] = field(default_factory=dict)

    def asked_in(self, lessons: Iterable[Lesson]) -> dict[QuestionId, AskedQuestion]:
        """Questions that the lessons still have, with an unchanged number of choices."""
        choices = {
            (lesson.id, step.id): len(step.question.choices)
            for lesson in lessons
            for step in lesson.steps
            if step.question is not None
        }
        return {
            one.question: one for one in self.asked if len(one.rounds[0].counts) == choices.get(one.question)
        }

    @property
    def empty(self) -> bool:
        return not (self.asked or self.passed or self.hand_ins or self.paired)
