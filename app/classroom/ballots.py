"""The answers of a class to the questions of the lessons: one of every student, counted without names."""

from collections.abc import Collection
from typing import NamedTuple

QuestionId = tuple[str, str]
"""Names of the lesson and the step of a question."""


class Tally(NamedTuple):
    """How a class has answered. `counts`: of every choice; `waiting`: how many of the present students have not answered."""

    counts: tuple[int, ...]
    waiting: int

    @property
    def answered(self) -> int:
        return sum(self.counts)

    @property
    def favourite(self) -> int | None:
        """The most frequent choice, the first of several; None without an answer."""
        return self.counts.index(max(self.counts)) if self.answered else None


class Ballots:
    """The answers of a class to every question so far, by the id of each student's tab; an answer outlives its student's connection."""

    def __init__(self) -> None:
        self._answers: dict[QuestionId, dict[str, int]] = {}
        self._revealed: set[QuestionId] = set()

    def answer(self, question: QuestionId, student: str, choice: int) -> bool:
        """Take an answer instead of an earlier one; return whether it was taken: not after the reveal."""
        if question in self._revealed or choice < 0:
            return False
        self._answers.setdefault(question, {})[student] = choice
        return True

    def answer_of(self, question: QuestionId, student: str) -> int | None:
        return self._answers.get(question, {}).get(student)

    def answers_of(self, student: str) -> dict[QuestionId, int]:
        return {question: answers[student] for question, answers in self._answers.items() if student in answers}

    def tally(self, question: QuestionId, choices: int, here: Collection[str]) -> Tally:
        """Return the counts of a question. `choices`: how many there are; `here`: the students who are present."""
        answers, counts = self._answers.get(question, {}), [0] * choices
        for choice in answers.values():
            if choice < choices:
                counts[choice] += 1
        return Tally(tuple(counts), len(set(here) - set(answers)))

    def reveal(self, question: QuestionId) -> None:
        """Show the tally to everybody; from now on no answer changes."""
        self._revealed.add(question)

    def revealed(self, question: QuestionId) -> bool:
        """Return whether everybody sees the tally."""
        return question in self._revealed

    def ask_again(self, question: QuestionId) -> None:
        """Delete all answers and ask the question again."""
        self._answers.pop(question, None)
        self._revealed.discard(question)
