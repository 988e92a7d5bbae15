"""A job pool that computes in this process, when `work` is called."""

import itertools
from collections.abc import Callable
from typing import Any

from app.runtime.job_pool import Job, JobPool
from controllers.errors import DuetError


class Inline(JobPool):
    """Jobs wait for `work`.

    Attributes:
        jobs: all that were ever submitted, in order.
    """

    def __init__(self) -> None:
        super().__init__(1)
        self.jobs: list[Job] = []
        self._count = itertools.count(1)

    def submit(
        self,
        owner: object,
        kind: str,
        function: Callable[..., Any],
        *arguments: Any,
        urgent: bool = False,
        wake: Callable[[], None] = lambda: None,
    ) -> Job:
        """Note a job; an older one of the same owner and kind is dropped."""
        self.cancel(owner, kind)
        job = Job(next(self._count), owner, kind, function, arguments, urgent, wake)
        self.jobs.append(job)
        return job

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
                job.result, job.state = job.function(*job.arguments, lambda: False), "done"
            except DuetError as error:
                job.state, job.message = "failed", str(error)
            job.wake()
        return [job.kind for job in jobs]
