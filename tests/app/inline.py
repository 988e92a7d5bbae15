"""A job pool that computes in this process, when `work` is called."""

from collections.abc import Callable
from typing import Any

from app.runtime.job_pool import Job, JobPool
from controllers.errors import DuetError


class Inline(JobPool):
    """Jobs wait for `work`; `jobs` are all that were ever submitted, in order."""

    def __init__(self) -> None:
        super().__init__(1)
        self.jobs: list[Job] = []

    def submit(
        self, owner: object, kind: str, function: Callable[..., Any], *arguments: Any, **options: Any
    ) -> Job:
        """Note a job; an older one of the same owner and kind is dropped."""
        self.cancel(owner, kind)
        urgent, wake = options.get("urgent", False), options.get("wake", lambda: None)
        self.jobs.append(Job(len(self.jobs) + 1, owner, kind, function, arguments, urgent, wake))
        return self.jobs[-1]

    def cancel(self, owner: object, kind: str | None = None) -> None:
        for job in self.waiting():
            if job.owner is owner and kind in (None, job.kind):
                job.state = "dropped"

    def waiting(self, kind: str = "") -> list[Job]:
        """What is to be done, of a kind that begins so."""
        return [job for job in self.jobs if job.state == "waiting" and job.kind.startswith(kind)]

    def work(self, kind: str = "") -> list[str]:
        """Do everything that waits, of a kind that begins so; the kinds of what was done."""
        jobs = self.waiting(kind)
        for job in jobs:
            try:
                job.result, job.state = job.function(*job.arguments), "done"
            except DuetError as error:
                job.state, job.message = "failed", str(error)
            job.wake()
        return [job.kind for job in jobs]
