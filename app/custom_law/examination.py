"""The six tests of a file, run in the background one after another; every verdict appears as soon as it is known."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from app.custom_law.custom_law import read_law
from app.custom_law.examine import examine_one
from app.custom_law.trial_result import TrialResult
from app.custom_law.trials import TRIALS
from app.runtime.job_pool import Job, Jobs
from controllers.errors import LazyText
from scenes.files import readable


class ExaminationProgress(NamedTuple):
    """How far the tests are.

    Attributes:
        file: name of the file that is tested; None if there is none.
        verdicts: known so far, in the order of `TRIALS`; empty if the tests were never made.
        running: whether there are more to come.
        message: why they could not be made; "" if all is well.
    """

    file: str | None
    verdicts: tuple[TrialResult, ...] = ()
    running: bool = False
    message: str = ""

    @property
    def finished(self) -> bool:
        return len(self.verdicts) == len(TRIALS)


NO_FILE = ExaminationProgress(None)
"""Where there is nothing to be tested."""


class Examination:
    """The tests of one visitor's file; all methods belong to one thread.

    Args:
        background: where they are made.
        wake: called, from any thread, when there is news.
    """

    def __init__(self, path: Path, background: Jobs, wake: Callable[[], None]) -> None:
        self._path, self._background, self._wake = path, background, wake
        self._jobs: list[Job] = []
        self.progress = self._none = ExaminationProgress(readable(path.name))

    def begin(self) -> None:
        """Make all tests on the file as it is now, whatever is saved meanwhile; tests that are under way are given up.

        Raises:
            BadInputFile: it cannot be read.
        """
        self.drop()
        text = read_law(self._path)
        self._jobs = [
            self._background.submit(self, name, examine_one, self._path, text, name, wake=self._wake) for name in TRIALS
        ]
        self.progress = self._none._replace(running=True)

    def advance(self) -> bool:
        """Take in what is known by now; return whether that is news."""
        if not self.progress.running:
            return False
        verdicts: list[TrialResult] = []
        for job in self._jobs:
            if job.state in ("failed", "dropped"):
                self.drop()
                message = job.message or LazyText("The tests were given up; make them again.")
                self.progress = self._none._replace(verdicts=tuple(verdicts), message=message)
                return True
            if job.state != "done":
                break
            verdicts.append(job.result)
        news = len(verdicts) != len(self.progress.verdicts)
        self.progress = self._none._replace(verdicts=tuple(verdicts), running=len(verdicts) < len(self._jobs))
        return news

    def drop(self) -> None:
        self._background.cancel(self)
        if self.progress.running:
            self.progress = self._none
