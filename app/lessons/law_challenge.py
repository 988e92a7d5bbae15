"""What a controller of the student's own is worth in a lesson: the six tests of `app.custom_law.trials` as inequalities of a challenge.

The page makes them on the student's file, in processes of their own; here a built-in law can stand in for it.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import ClassVar, Final

from app.custom_law.law_limits import LawProblem
from app.custom_law.trial_result import TrialResult
from app.custom_law.trials import TRIALS, WHY, examine_law
from app.lessons.outcomes import Attempt, Judgement
from controllers.errors import LazyText, joined
from controllers.kinematics import Array
from controllers.laws.situation import Law, Situation
from scenes.law_factory import make_law
from scenes.settings import LawSettings

TESTS: Final = tuple(TRIALS)
"""Names, in their order."""


class StandIn:
    """A law that never fails, as the tests want one."""

    wants_all_pairs: ClassVar[bool] = True
    wants_task: ClassVar[bool] = True
    problem: LawProblem | None = None
    seconds: float = 0.0
    """A built-in law is quick on any machine."""

    def __init__(self, law: Law | Callable[[Situation], Array]) -> None:
        self._law = law

    def __call__(self, situation: Situation) -> Array:
        return self._law(situation)

    def activation(self, distance: float) -> float:
        """Return nothing: no test asks for λ."""
        del distance
        return 0.0

    def line_rate(self, distance: float, pull: float, approach: float, square: float) -> float:
        """Return nan: no test asks for it."""
        del distance, pull, approach, square
        return float("nan")


def attempt_of(verdicts: Sequence[TrialResult]) -> Attempt:
    """Return how a controller did; a test that fails says why it is asked for."""
    judgements: list[Judgement] = []
    for verdict in verdicts:
        why = () if verdict.passed else (LazyText(WHY[verdict.name]),)
        outcome = LazyText("{test}: {reason}", test=LazyText(verdict.name), reason=verdict.reason)
        judgements.append(Judgement(verdict.name, verdict.passed, joined((outcome, *why), " "), None))
    return Attempt.of(judgements)


def examine(law: StandIn, only: Sequence[str] = TESTS) -> Attempt:
    """Return the result of a built-in law. `only`: names of the tests to run."""
    return attempt_of(examine_law(law, only=only))


def stand_in(name: str) -> StandIn:
    """Return a built-in law, by name, with d_m and v as the tests ask for."""
    return StandIn(make_law(replace(LawSettings(), law=name)))  # pyright: ignore[reportArgumentType]
