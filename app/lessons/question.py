"""A question of a step: its answers, and what a measured value says of them."""

from dataclasses import dataclass

from app.lessons.measures.quantity import Value
from app.lessons.runs import Setup


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
