"""What a class leaves behind: the questions with their counts, the challenges that were passed, and the reports that were handed in."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from app.features.lessons.lesson import Lesson
from app.features.lessons.tally import QuestionId, Switch, Tally


@dataclass(frozen=True)
class AskedQuestion:
    """A question that a class has answered.

    Attributes:
        question: lesson and step.
        rounds: the counts each time it was asked.
        switches: from the first round to the last one; () for one round.
    """

    question: QuestionId
    rounds: tuple[Tally, ...]
    switches: tuple[Switch, ...] = ()


@dataclass(frozen=True)
class HandIn:
    """What one student has handed in.

    Attributes:
        name: that the student has typed; "" for none.
        progress: what was done in the lessons, as `app.features.lessons.progress.to_json` writes it.
        answers: question of the class → the student's answer in every round, None without an answer.
    """

    name: str
    progress: str
    answers: Mapping[QuestionId, tuple[int | None, ...]] = field(default_factory=dict)


@dataclass(frozen=True)
class ClassSummary:
    """A class as plain data, without names but for those in `hand_ins`.

    Attributes:
        saved: when it was so [s since 1970].
        students: how many have answered a question.
        asked: in the order in which they were answered.
        passed: lesson and step → how many students have passed its challenge.
        hand_ins: by name, those without one at the end.
        paired: question of a test that is asked twice → the answers before and after, from 0, of each student who gave both.
    """

    saved: float
    students: int
    asked: tuple[AskedQuestion, ...]
    passed: Mapping[QuestionId, int] = field(default_factory=dict)
    hand_ins: tuple[HandIn, ...] = ()
    paired: Mapping[QuestionId, tuple[tuple[int, int], ...]] = field(default_factory=dict)

    def asked_in(self, lessons: Iterable[Lesson]) -> dict[QuestionId, AskedQuestion]:
        """Return the questions that the lessons still have, with as many answers as when they were asked."""
        choices = {
            (lesson.id, step.id): len(step.question.choices)
            for lesson in lessons
            for step in lesson.steps
            if step.question is not None
        }
        return {one.question: one for one in self.asked if len(one.rounds[0].counts) == choices.get(one.question)}

    @property
    def empty(self) -> bool:
        """True if there is nothing to report."""
        return not (self.asked or self.passed or self.hand_ins or self.paired)
