"""A job pool that computes in this process, when `work` is called."""

from collections.abc import Callable
from typing import Any

from app.runtime.job_pool import Job, JobPool
from controllers.errors import DuetError


class Inline(JobPool):
    """Jobs wait for `work`. `jobs`: all submitted ones, in order."""

    def __init__(self) -> None:
        super().__init__(1)
        self.jobs: list[Job] = []

    def submit(
        self, owner: object, kind: str, function: Callable[..., Any], *arguments: Any, **options: Any
    ) -> Job:
        """Add a job; it replaces an older one of the same owner and kind."""
        self.cancel(owner, kind)
        urgent, wake = options.get("urgent", False), options.get("wake", lambda: None)
        self.jobs.append(Job(len(self.jobs) + 1, owner, kind, function, arguments, urgent, wake))
        return self.jobs[-1]

    def cancel(self, owner: object, kind: str | None = None) -> None:
        for job in self.waiting():
            if job.owner is owner and kind in (None, job.kind):
                job.state = "dropped"

    def waiting(self, kind: str = "") -> list[Job]:
        """Waiting jobs of kinds that begin with `kind`."""
        return [job for job in self.jobs if job.state == "waiting" and job.kind.startswith(kind)]

    def work(self, kind: str = "") -> list[str]:
        """Do all waiting jobs of kinds that begin with `kind`. Return their kinds."""
        jobs = self.waiting(kind)
        for job in jobs:
            try:
                job.result, job.state = job.function(*job.arguments), "done"
            except DuetError as error:
                job.state, job.message = "failed", str(error)
            job.wake()
        return [job.kind for job in jobs]
