"""A result of the present settings that is computed part by part in the background, while it is shown."""

from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

from app.runtime.job_pool import Job, Jobs
from scenes.settings import RunSettings

Part = TypeVar("Part")
Result = TypeVar("Result")


class BackgroundParts(Generic[Part, Result]):
    """The parts of one session's result; computed when they are first asked for, and again when the settings have changed.

    Args:
        background: where they are computed.
        wake: called when there is a further part.
        parts: what is computed one by one.
        compute: (settings, part, stopped) → result, at a module's top level.
        relevant: the settings of a run with fixed values for all that does not matter.
    """

    def __init__(
        self,
        background: Jobs,
        wake: Callable[[], None],
        parts: Sequence[Part],
        compute: Callable[[RunSettings, Part, Callable[[], bool]], Result],
        relevant: Callable[[RunSettings], RunSettings],
    ) -> None:
        self._background, self._wake = background, wake
        self._parts, self._compute, self._relevant = parts, compute, relevant
        self._of: RunSettings | None = None
        self._jobs: list[Job] = []

    def results(self, run: RunSettings) -> dict[Part, Result]:
        """Return what is there already, part by part."""
        of = self._relevant(run)
        if of != self._of:
            self.forget()
            self._of = of
            self._jobs = [
                self._background.submit(self, f"{part}", self._compute, of, part, wake=self._wake) for part in self._parts
            ]
        return {part: job.result for part, job in zip(self._parts, self._jobs, strict=True) if job.result is not None}

    @property
    def size(self) -> float:
        """How much of it is there, from 0 to 1."""
        return sum(job.result is not None for job in self._jobs) / len(self._parts)

    def forget(self) -> None:
        """Drop the results, and what is being computed."""
        self._background.cancel(self)
        self._of, self._jobs = None, []
