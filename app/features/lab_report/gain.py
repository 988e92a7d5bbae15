"""Two equal tests, before and after the lessons.

Normalised gain: Hake, American Journal of Physics 66 (1998): gain over possible gain.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from app.features.lessons.lesson import LAST, Lesson, Step
from app.features.lessons.progress import StepProgress
from app.features.lessons.tally import QuestionId

AnswerPairs = Mapping[QuestionId, Sequence[tuple[int, int]]]
"""Question of the first test → each student's answers before and after (0-based)."""


@dataclass(frozen=True)
class Gain:
    """Right answers before and after. `students`: who answered twice; for several questions, pairs."""

    students: int
    before: int
    after: int

    @property
    def normalised(self) -> float | None:
        """⟨g⟩; None if all were right before."""
        possible = self.students - self.before
        return (self.after - self.before) / possible if possible else None

    @property
    def cells(self) -> tuple[str, str, str, str]:
        """Students, shares before and after [%] and ⟨g⟩."""
        before, after = (f"{100.0 * count / self.students:.0f} %" for count in (self.before, self.after))
        return (
            str(self.students),
            before,
            after,
            "–" if self.normalised is None else f"{self.normalised:.2f}".replace("-", "−"),
        )


@dataclass(frozen=True)
class QuestionGain:
    """Answers to one question. `moved`: counts of answers, rows before, columns after."""

    lesson: Lesson
    step: Step
    index: int
    gain: Gain
    moved: tuple[tuple[int, ...], ...]
    right: int

    @property
    def belief(self) -> str:
        """Markdown."""
        return self.step.belief.partition("\n")[0] or self.step.title


def gains(pairs: AnswerPairs, lessons: Iterable[Lesson]) -> list[QuestionGain]:
    """Questions that students have answered twice, in order."""
    found: list[QuestionGain] = []
    for lesson in lessons:
        for index, step in enumerate(lesson.steps if lesson.asked == "first" else ()):
            if step.question is None:
                continue
            count, right = len(step.question.choices), step.question.right
            both = [pair for pair in pairs.get((lesson.id, step.id), ()) if max(pair) < count]
            if both:
                gain = Gain(len(both), sum(a == right for a, _ in both), sum(b == right for _, b in both))
                moved = tuple(
                    tuple(both.count((before, after)) for after in range(count)) for before in range(count)
                )
                found.append(QuestionGain(lesson, step, index, gain, moved, right))
    return found


def whole(questions: Iterable[QuestionGain]) -> Gain:
    each = [one.gain for one in questions]
    return Gain(
        sum(one.students for one in each), sum(one.before for one in each), sum(one.after for one in each)
    )


def own_pairs(lessons: Iterable[Lesson], progress: Callable[[str, str], StepProgress]) -> AnswerPairs:
    """Answers to tests with revealed answers. `progress`: of lesson and step."""
    pairs: dict[QuestionId, Sequence[tuple[int, int]]] = {}
    for lesson in lessons:
        for step in lesson.steps if lesson.asked == "first" else ():
            first, last = progress(lesson.id, step.id).choice, progress(lesson.id + LAST, step.id)
            if first is not None and last.choice is not None and last.outcome is not None:
                pairs[lesson.id, step.id] = ((first, last.choice),)
    return pairs
