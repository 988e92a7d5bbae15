"""The further runs that a step of a lesson compares with, made in another thread before they are needed."""

import logging
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Final

from app.lessons.lesson import Setup, Step
from app.lessons.outcomes import reference
from app.lessons.reference_runs import measured, wanted

log = logging.getLogger("duet.lessons")

_RUNS: Final = ThreadPoolExecutor(1, "duet-lessons")
"""Where further runs are made; one after another, so that pages go on."""


class FurtherRuns:
    """The further runs of the step that one session is in."""

    def __init__(self) -> None:
        self._made: tuple[object, Future[None]] | None = None

    def prepare(self, lesson: str, step: Step, why: Setup | None) -> None:
        """Begin to make what a step compares with, unless it has begun already.

        Args:
            lesson, step: which.
            why: the run that shows why an answer is wrong, while that one is on.
        """
        key = lesson, step.id, why is not None
        if self._made is None or self._made[0] != key:
            self._made = key, _RUNS.submit(_make_runs, step, why)

    @property
    def ready(self) -> bool:
        """Return whether nothing has to be waited for."""
        return self._made is None or self._made[1].done()

    def wait(self, seconds: float) -> None:
        """Wait until everything is made.

        Raises:
            TimeoutError: it takes longer.
        """
        if self._made is not None:
            self._made[1].result(seconds)


def _make_runs(step: Step, why: Setup | None) -> None:
    """Make every further run that a step compares with, so that they are known when they are needed."""
    try:
        if why is not None:
            reference(step, why)
            return
        if step.measurements:
            reference(step, step.setup)
        if step.challenge is not None:
            for forecast in step.challenge.forecasts:
                measured(step.challenge.setup.with_changes(forecast.changes), wanted((forecast.measurement,)))
    except Exception:
        log.exception("the runs that a step compares with could not be made")
