"""The jobs of one owner, each with what is done with its result, on the owner's own thread."""

from collections.abc import Callable
from typing import Any

from app.runtime.job_pool import Job, Jobs


class JobWatch:
    """Submits jobs and collects their results. All methods belong to one thread.

    Args:
        background: runs the jobs; with None there are none, and what is submitted is left out.
        wake: called, from any thread, when the state of a job has changed.
        failed: called by `collect` with a job that has failed.
    """

    def __init__(self, background: Jobs | None, wake: Callable[[], None], failed: Callable[[Job], None]) -> None:
        self._background, self._wake, self._failed = background, wake, failed
        self.computes = background is not None
        """Whether there is what runs the jobs."""
        self._jobs: dict[Job, Callable[[Any], None]] = {}

    @property
    def kinds(self) -> tuple[str, ...]:
        """The kinds of the jobs under way, oldest first."""
        return tuple(job.kind for job in self._jobs)

    def submit(
        self, kind: str, done: Callable[[Any], None], function: Callable[..., Any], *arguments: Any, urgent: bool = False
    ) -> None:
        """Submit a job in the place of an older one of its kind, see `Jobs.submit`; `collect` calls `done` with its result."""
        self.drop(kind)
        if self._background is not None:
            self._jobs[self._background.submit(self, kind, function, *arguments, urgent=urgent, wake=self._wake)] = done

    def drop(self, kind: str) -> None:
        if self._background is not None:
            self._background.cancel(self, kind)
        self._jobs = {job: done for job, done in self._jobs.items() if job.kind != kind}

    def collect(self) -> None:
        for job, done in list(self._jobs.items()):
            # Handing over one result may drop another job.
            if job.state in ("waiting", "running") or self._jobs.pop(job, None) is None:
                continue
            if job.state == "done":
                done(job.result)
            elif job.state == "failed":
                self._failed(job)

    def close(self) -> None:
        if self._background is not None:
            self._background.cancel(self)
        self._jobs.clear()
