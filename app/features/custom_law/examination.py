"""The six tests of a file."""

import hashlib
import itertools
import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from time import perf_counter
from typing import NamedTuple

import numpy as np

from app.features.custom_law import template
from app.features.custom_law.arena import TrialResult
from app.features.custom_law.custom_law import CustomLaw, read_law
from app.features.custom_law.law_limits import LawLimits, processor_time, without_core
from app.features.custom_law.trials import TRIALS, advice, verdict_on
from app.runtime.job_pool import Job, Jobs
from controllers.errors import LazyText
from controllers.kinematics import Array
from controllers.laws.situation import Situation
from scenes.files import readable
from scenes.wanted import check_wanted


def examine(
    path: Path,
    limits: LawLimits = LawLimits(),  # noqa: B008 (frozen)
    only: Sequence[str] | None = None,
    text: bytes | None = None,
) -> Iterator[TrialResult]:
    """Verdicts of the tests, each as soon as known; a failed law is restarted for the next.

    Args:
        only: names of tests; None for all.
        text: content to test; None for the file's.

    Raises:
        BadInputFile: the file cannot be read.
        Stopped: before a call, see `scenes.wanted`.
    """
    with _Examined(path, limits, text) as law:
        if not law.load():
            # It cannot be loaded: one reason for all.
            reason, line = law.problem or ("the file could not be loaded.", None)
            yield from (TrialResult(name, False, reason, line=line) for name in only or TRIALS)
            return
        for name in only or TRIALS:
            if law.problem is not None:
                law.problem = None
                law.restart()
            yield replace(verdict_on(law, name), as_template=law.as_template)


def examine_one(path: Path, text: bytes, name: str) -> TrialResult:
    return next(examine(path, only=(name,), text=text))


class _Examined(CustomLaw):
    """Stops on request, and times calls itself, since a file can change its process's clock."""

    def __init__(self, path: Path, limits: LawLimits, text: bytes | None) -> None:
        super().__init__(path, limits, waits=True, text=text)
        self.as_template = True
        self._seconds = float("nan")

    def __call__(self, situation: Situation) -> Array:
        check_wanted()
        begin, used = perf_counter() - self._without_core, self._processor_time
        velocities = super().__call__(situation)
        # If both processes wait for a core, both waits are subtracted: the computing time is a lower bound.
        self._seconds = max(
            perf_counter() - self._without_core - begin, self._processor_time - used, super().seconds
        )
        # The velocities of a failed law are 0.
        self.as_template &= np.allclose(velocities, template.law(situation), rtol=1e-6, atol=1e-9)
        return velocities

    @property
    def seconds(self) -> float:
        """Time of the last call, without waiting for a core [s]."""
        return self._seconds

    @property
    def _processor_time(self) -> float:
        """Time so far [s]; 0 if unknown."""
        return (self.pid is not None and processor_time(self.pid)) or 0.0

    @property
    def _without_core(self) -> float:
        return without_core(os.getpid()) + (without_core(self.pid) if self.pid is not None else 0.0)


def verdict_table(path: Path, verdicts: list[TrialResult]) -> str:
    width = max(len(verdict.name) for verdict in verdicts)
    lines = [
        f"{'pass' if v.passed else 'FAIL'}  {v.name:{width}}  {v.reason}{'' if v.passed else f' {advice(v.name)}'}"
        for v in verdicts
    ]
    passed = sum(v.passed for v in verdicts)
    return "\n".join([*lines, f"{readable(path.name)}: {passed} of {len(verdicts)} tests passed."])


class ExaminationProgress(NamedTuple):
    """Progress of the tests.

    Attributes:
        verdicts: in the order of `TRIALS`; empty before the tests.
        message: why they could not be made, or "".
        typed: true if the law is typed on the page.
        number: of this run of the tests, unique in this process; 0 before the first of a file.
        stale: true if the file was changed since.
    """

    file: str | None = None
    verdicts: tuple[TrialResult, ...] = ()
    running: bool = False
    message: str = ""
    typed: bool = False
    number: int = 0
    stale: bool = False

    @property
    def finished(self) -> bool:
        return len(self.verdicts) == len(TRIALS)


_NUMBERS = itertools.count(1)


class Examination:
    """Tests of a visitor's file, on one thread. `wake`: called from any thread on a new result."""

    def __init__(self, path: Path, background: Jobs, wake: Callable[[], None]) -> None:
        self._path, self._background, self._wake = path, background, wake
        self._jobs: list[Job] = []
        self._version = ""
        self.progress = self._none = ExaminationProgress(readable(path.name))

    def begin(self) -> None:
        """Restart all tests on the current content of the file.

        Raises:
            BadInputFile: the file cannot be read.
        """
        self.drop()
        function, arguments, self._version = self._one_test()
        self._jobs = [
            self._background.submit(self, name, function, *arguments, name, wake=self._wake)
            for name in TRIALS
        ]
        # A saved text gets a new object, so a count of its own would begin at 1 again.
        self._none = self._none._replace(number=next(_NUMBERS))
        self.progress = self._none._replace(running=True)

    def _one_test(self) -> tuple[Callable[..., TrialResult], tuple[object, ...], str]:
        """Function, its arguments before the test's name, and SHA-256 of the text; "" if it cannot change."""
        text = read_law(self._path)
        return examine_one, (self._path, text), hashlib.sha256(text).hexdigest()

    def advance(self) -> bool:
        if not self.progress.running:
            return False
        verdicts: list[TrialResult] = []
        for job in self._jobs:
            if job.state in ("failed", "dropped"):
                self.drop()
                message = job.message or LazyText("The tests were stopped; start them again.")
                self.progress = self._none._replace(verdicts=tuple(verdicts), message=message)
                return True
            if job.state != "done":
                break
            verdicts.append(job.result)
        news = len(verdicts) != len(self.progress.verdicts)
        self.progress = self._none._replace(verdicts=tuple(verdicts), running=len(verdicts) < len(self._jobs))
        return news

    def compare(self, version: str) -> None:
        """Mark results of another version of the file as stale. `version`: the SHA-256 of its text."""
        stale = self.progress.finished and self._version not in ("", version)
        if stale != self.progress.stale:
            self.progress = self.progress._replace(stale=stale)

    def drop(self) -> None:
        self._background.cancel(self)
        if self.progress.running:
            self.progress = self._none
