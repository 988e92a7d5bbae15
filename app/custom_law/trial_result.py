"""The result of a test of a law."""

from dataclasses import dataclass
from typing import Protocol

from app.custom_law.law_limits import LawProblem
from controllers.laws.situation import Law


@dataclass(frozen=True)
class TrialResult:
    """Of one test.

    Attributes:
        reason: which one, and by how much it holds or fails; a `Message`.
        numbers: behind it, SI units.
    """

    name: str
    passed: bool
    reason: str
    numbers: dict[str, float]


class Candidate(Law, Protocol):
    """A law that may fail.

    Attributes:
        problem: why it has; None if it has not.
        seconds: time that its newest call took [s].
    """

    @property
    def problem(self) -> LawProblem | None: ...

    @property
    def seconds(self) -> float: ...
