"""Attempts at a challenge: whether a run counts, and what is said if it does not."""

from collections.abc import Sequence
from dataclasses import replace
from math import inf

from app.i18n.speaking import N_
from app.lessons.evidence import Evidence
from app.lessons.lesson import Challenge
from app.lessons.outcomes import Attempt, judge
from controllers.errors import LazyText
from scenes.settings import RunSettings
from scenes.simulation import Simulation


class RunWatch:
    """Watches one run.

    Attributes:
        mixed: whether settings have changed in the middle of it.
    """

    def __init__(self) -> None:
        self.mixed = False
        self._seen: tuple[int, RunSettings] | None = None

    def begin(self) -> None:
        self._seen, self.mixed = None, False

    def see(self, simulation: Simulation) -> None:
        """Take note of the run as it is now; fewer steps than before mean a restart."""
        steps, settings = simulation.steps, simulation.settings
        if self._seen is None or steps < self._seen[0] or self._seen[0] == 0:
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
    """Return how a run stands up to a challenge; it does not count if settings were mixed in it, or before its end.

    Args:
        said: the student's forecasts, where the challenge asks for any.
        yours: whether the student moves, so that any moment may be the end.
        finished: whether the run is as long as the challenge asks for.
        mixed: see `RunWatch`.
    """
    attempt = judge(challenge, Evidence(simulation, inf if yours else challenge.setup.seconds), said)
    note, seconds = "", f"{challenge.setup.seconds:g} s"
    if challenge.criteria and mixed:
        note = N_("The settings changed during the run. Reset, then run again, so that all of it is under the same settings.")
    elif challenge.criteria and not yours and not finished:
        note = N_("The run is not over yet. Let it go on to {seconds}, then try again.")
    return replace(attempt, passed=False, note=LazyText(note, seconds=seconds)) if note else attempt
