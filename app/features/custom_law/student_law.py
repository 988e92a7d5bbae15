"""The custom law of a session."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Protocol

from app.features.custom_law.custom_law import CustomLaw
from app.features.custom_law.examination import Examination, ExaminationProgress
from app.features.custom_law.law_limits import SHARE, LawProblem, LawTimeShare
from app.runtime.job_pool import Jobs
from app.session.clock import LONGEST_GAP
from app.session.late_law import LateLaw, LateLawStatus
from app.session.session import Session
from controllers.laws.situation import Law
from scenes.settings import RunSettings


class SessionLaw(Law, Protocol):
    """See `CustomLaw`."""

    file: str
    sha256: str
    problem: LawProblem | None

    @property
    def need(self) -> float: ...

    @property
    def away(self) -> bool: ...

    @property
    def waiting(self) -> bool: ...

    def allow(self, seconds: float) -> None: ...

    def refresh(self) -> bool: ...

    def step_made(self) -> int: ...

    def close(self) -> None: ...


class StudentLaw(LateLaw):
    """A session's law; does nothing without one. `share`: waiting time of all sessions' laws."""

    def __init__(
        self, path: Path | None, share: LawTimeShare, background: Jobs | None, wake: Callable[[], None]
    ) -> None:
        self.in_ghost, self.enabled = False, True
        self.path: Path | None = None
        self.examination: Examination | None = None
        self.law: SessionLaw | None = None
        self._background, self._wake, self._share = background, wake, share
        if path is not None:
            self.open(path)
        self._part = SHARE
        self._allowed = math.inf
        """Longest call in real time [s]."""

    def open(self, path: Path) -> None:
        """Replace the law.

        Raises:
            BadInputFile: the file cannot be read; nothing is changed.
        """
        law = CustomLaw(path)
        self.take(law, None if self._background is None else Examination(path, self._background, self._wake))
        self.path = path

    def take(self, law: SessionLaw | None, tests: Examination | None = None) -> None:
        """Replace the law by one without a file. `tests`: of the new law."""
        self.close()
        self.law, self.path, self.examination = law, None, tests

    @property
    def given(self) -> bool:
        return self.law is not None

    @property
    def of_run(self) -> SessionLaw | None:
        return self.law if self.enabled and not self.in_ghost else None

    @property
    def of_ghost(self) -> SessionLaw | None:
        return self.law if self.enabled and self.in_ghost else None

    @property
    def waits(self) -> bool:
        law = self.law if self.enabled else None
        return law is not None and law.waiting

    def status(self, late: bool) -> LateLawStatus:
        law = self.law
        if law is None or not self.enabled:
            return LateLawStatus(away=law is not None and law.away)
        file, ghost_file = (None, law.file) if self.in_ghost else (law.file, None)
        slow = (law.need, self._allowed) if late and law.need > self._allowed else None
        problem, line = law.problem or ("", None)
        return LateLawStatus(file, ghost_file, problem, law.away, law.waiting, slow, law.sha256, line)

    def advance(self, elapsed: float, paused: bool) -> None:
        if self.examination is not None:
            self.examination.advance()
        if self.law is None:
            return
        self.law.refresh()
        if self.examination is not None:
            self.examination.compare(self.law.sha256)
        if self.enabled and not paused:
            self._part = self._share.part(id(self))
        self.law.allow(self._part * min(elapsed, LONGEST_GAP))

    def step_made(self, run: RunSettings, speed: float) -> None:
        if self.law is not None:
            self._allowed = self._part * run.dt / speed / max(self.law.step_made(), 1)

    def close(self) -> None:
        if self.law is not None:
            self.law.close()
        if self.examination is not None:
            self.examination.drop()


def student_law(session: Session) -> StudentLaw:
    """The session's law; by default without a file."""
    if not isinstance(session.law, StudentLaw):
        law = StudentLaw(None, LawTimeShare(), session.background, session.wake)
        law.in_ghost = session.law.in_ghost
        session.law = law
    return session.law


def let_custom_law_run(session: Session, runs: bool) -> None:
    law = student_law(session)
    if runs != law.enabled:
        law.enabled = runs
        session.assign_laws(law.given)


def take_law_file(session: Session, path: Path) -> None:
    """Run a file's law; resets the run.

    Raises:
        BadInputFile: the file cannot be read; nothing is changed.
    """
    student_law(session).open(path)
    session.assign_laws(True)


def examination(session: Session) -> Examination | None:
    return session.law.examination if isinstance(session.law, StudentLaw) else None


def tests_of(session: Session) -> ExaminationProgress:
    tests = examination(session)
    return ExaminationProgress() if tests is None else tests.progress
