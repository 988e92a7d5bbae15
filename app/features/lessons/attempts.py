"""Attempts at a challenge."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import inf
from typing import ClassVar

from app.features.custom_law.arena import TrialResult
from app.features.custom_law.law_limits import LawProblem
from app.features.custom_law.trials import WHY
from app.features.lessons.lesson import Challenge
from app.features.lessons.outcomes import Attempt, Judgement, judge
from app.features.measures.evidence import Evidence
from app.i18n.speaking import N_
from controllers.errors import LazyText, NumberText, joined
from controllers.kinematics import Array
from controllers.laws.situation import Law, Situation
from scenes.settings import RunSettings
from scenes.simulation import Simulation


class RunWatch:
    """Detects restarts (counted in `run`) and changed settings (`mixed`)."""

    def __init__(self) -> None:
        self.mixed, self.run = False, 0
        self._seen: tuple[int, RunSettings] | None = None

    def begin(self) -> None:
        self._seen, self.mixed = None, False
        self.run += 1

    def see(self, simulation: Simulation) -> None:
        steps, settings = simulation.steps, simulation.settings
        if self._seen is None or steps < self._seen[0] or self._seen[0] == 0:
            self.run += self._seen is not None and steps < self._seen[0]
            self.mixed = False
        elif settings != self._seen[1]:
            self.mixed = True
        self._seen = (steps, settings)


def attempted(
    challenge: Challenge,
    simulation: Simulation,
    said: Sequence[float | None],
    *,
    yours: bool,
    finished: bool,
    mixed: bool,
) -> Attempt:
    """Judge a run, which counts only at its end (at any time if `yours`), and without changed settings."""
    if challenge.criteria and simulation.steps == 0:
        return Attempt(False, (), LazyText(N_("Press Run first.")))
    attempt = judge(challenge, Evidence(simulation, inf if yours else challenge.setup.seconds), said)
    note, seconds = "", NumberText(f"{challenge.setup.seconds:g} s")
    if challenge.criteria and mixed:
        note = N_(
            "The settings changed during the run. Reset, then run again, so that all of it is under the same settings."
        )
        if challenge.best_of:
            note = N_("The settings changed during this push, so it does not count. Press Next push.")
    elif challenge.criteria and not yours and not finished:
        note = N_("The run is too short. Continue it to {seconds}, then try again.")
    return replace(attempt, passed=False, note=LazyText(note, seconds=seconds)) if note else attempt


class StandIn:
    """Built-in law with the interface of a custom law; the tests ask only for q̇."""

    wants_all_pairs: ClassVar[bool] = True
    wants_task: ClassVar[bool] = True
    problem: LawProblem | None = None
    seconds: float = 0.0

    def __init__(self, law: Law | Callable[[Situation], Array]) -> None:
        self._law = law

    def __call__(self, situation: Situation) -> Array:
        return self._law(situation)

    def activation(self, distance: float) -> float:
        del distance
        return 0.0

    def line_rate(self, distance: float, pull: float, approach: float, square: float) -> float:
        del distance, pull, approach, square
        return float("nan")


def attempt_of(verdicts: Sequence[TrialResult]) -> Attempt:
    judgements: list[Judgement] = []
    for verdict in verdicts:
        why = () if verdict.passed else (LazyText(WHY[verdict.name]),)
        outcome = LazyText("{test}: {reason}", test=LazyText(verdict.name), reason=verdict.reason)
        judgements.append(Judgement(verdict.name, verdict.passed, joined((outcome, *why), " "), None))
    return Attempt.of(judgements)
