"""What a class predicts: one answer for every student and question, counted without names."""

from collections.abc import Collection
from typing import NamedTuple

Place = tuple[str, str]
"""Lesson and step of a question, by name."""


class Tally(NamedTuple):
    """How a class has answered.

    Attributes:
        counts: of every choice.
        waiting: how many of those who are here have not answered.
    """

    counts: tuple[int, ...]
    waiting: int

    @property
    def answered(self) -> int:
        """How many answers there are."""
        return sum(self.counts)

    @property
    def favourite(self) -> int | None:
        """The choice that most have taken, the first of several; None without an answer."""
        return self.counts.index(max(self.counts)) if self.answered else None


class Ballots:
    """The answers of a class to every question so far. A student is known by a word that their tab keeps, so that nobody counts twice.

    An answer outlives its student's connection: it is there again after a reload, and it counts when they are gone.
    """

    def __init__(self) -> None:
        self._answers: dict[Place, dict[str, int]] = {}
        self._revealed: set[Place] = set()

    def answer(self, place: Place, who: str, choice: int) -> bool:
        """Take an answer, or another one instead of it; return whether it was taken: not after the reveal."""
        if place in self._revealed or choice < 0:
            return False
        self._answers.setdefault(place, {})[who] = choice
        return True

    def answer_of(self, place: Place, who: str) -> int | None:
        """Return what a student has answered; None if nothing."""
        return self._answers.get(place, {}).get(who)

    def answers_of(self, who: str) -> dict[Place, int]:
        """Return all that a student has answered."""
        return {place: answers[who] for place, answers in self._answers.items() if who in answers}

    def tally(self, place: Place, choices: int, here: Collection[str]) -> Tally:
        """Return how the class has answered. `choices`: how many there are; `here`: the words of those who are here now."""
        answers, counts = self._answers.get(place, {}), [0] * choices
        for choice in answers.values():
            if choice < choices:
                counts[choice] += 1
        return Tally(tuple(counts), sum(1 for who in set(here) if who not in answers))

    def reveal(self, place: Place) -> None:
        """Show everybody what the class has answered; from now on nothing changes."""
        self._revealed.add(place)

    def revealed(self, place: Place) -> bool:
        """Return whether everybody may see what the class has answered."""
        return place in self._revealed

    def ask_again(self, place: Place) -> None:
        """Ask anew: as if nobody had answered."""
        self._answers.pop(place, None)
        self._revealed.discard(place)
