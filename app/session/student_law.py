"""The law of a student's file in one session: which run uses it, and how long it may be waited for."""

import math
from collections.abc import Callable
from typing import NamedTuple

from app.custom_law.custom_law import CustomLaw
from app.custom_law.examination import Examination, ExaminationProgress
from app.custom_law.law_limits import SHARE
from app.runtime.job_pool import Jobs
from app.session.clock import LONGEST_GAP
from app.session.input_source import InputSources
from scenes.settings import RunSettings


class LawStatus(NamedTuple):
    """How the student's law fares, for the page.

    Attributes:
        file: name of the file of the law that runs instead of the settings' law; None if theirs does.
        ghost_file: the same of the ghost.
        problem: why the law is not in force, and its arm stands still; "" if all is well, or no run uses it.
        away: whether the file is gone; what it said last stays in force.
        waits: whether the run waits for the law's answer.
        slow: how long a call takes, and how long it may in real time [s]; None unless it slows down the run.
        sha256: of the file, in hexadecimal digits.
        line: of the file that `problem` is about, counted from 1; None for none.
    """

    file: str | None = None
    ghost_file: str | None = None
    problem: str = ""
    away: bool = False
    waits: bool = False
    slow: tuple[float, float] | None = None
    sha256: str = ""
    line: int | None = None


class StudentLaw:
    """The law that a session runs in a process of its own; nothing happens here in a session without a file.

    Args:
        sources: with the file, if there is one, and with how long the laws of all sessions together may be waited for.
        background, wake: where the file is tested, and what is called when there is news, see `Examination`.
        in_ghost: whether the ghost uses it, not the run.

    Attributes:
        in_ghost: see there.
        enabled: whether one of them uses it at all.
        examination: the tests of the file; None where there is none, or no background.
    """

    def __init__(self, sources: InputSources, background: Jobs | None, wake: Callable[[], None], in_ghost: bool) -> None:
        self.in_ghost, self.enabled = in_ghost, True
        self.examination: Examination | None = None
        self._law: CustomLaw | None = None
        self._background, self._wake = background, wake
        self.open(sources)
        self._share = sources.law_share
        self._part = SHARE
        """Part of the wall time that its calls may be waited for."""
        self._allowed = math.inf
        """Time that a call of it may take in real time [s]."""

    def open(self, sources: InputSources) -> None:
        """Take the file of the sources, as it is now, in the place of the one that there was.

        Raises:
            BadInputFile: it cannot be read; nothing is changed.
        """
        if sources.law_file is not None:
            law = CustomLaw(sources.law_file)
            self.close()
            self._law = law
            if self._background is not None:
                self.examination = Examination(sources.law_file, self._background, self._wake)

    @property
    def of_run(self) -> CustomLaw | None:
        """The law, if the run uses it."""
        return self._law if self.enabled and not self.in_ghost else None

    @property
    def of_ghost(self) -> CustomLaw | None:
        """The law, if the ghost uses it."""
        return self._law if self.enabled and self.in_ghost else None

    @property
    def waits(self) -> bool:
        """Whether everything stands still because the law has not answered yet."""
        law = self._law if self.enabled else None
        return law is not None and law.waiting

    def status(self, late: bool) -> LawStatus:
        """Return how the law fares. `late`: whether the run cannot keep up with the speed asked for."""
        law = self._law
        if law is None or not self.enabled:
            return LawStatus(away=law is not None and law.away)
        file, ghost_file = (None, law.file) if self.in_ghost else (law.file, None)
        slow = (law.need, self._allowed) if late and law.need > self._allowed else None
        problem, line = law.problem or ("", None)
        return LawStatus(file, ghost_file, problem, law.away, law.waiting, slow, law.sha256, line)

    @property
    def tests(self) -> ExaminationProgress:
        """How far the tests of the law are."""
        return ExaminationProgress() if self.examination is None else self.examination.progress

    def advance(self, elapsed: float, paused: bool) -> None:
        """Look at the file, and let the law have its share of a frame. `elapsed`: wall time since the last one [s]."""
        if self.examination is not None:
            self.examination.advance()
        if self._law is None:
            return
        self._law.refresh()
        if self.enabled and not paused:
            self._part = self._share.part(id(self))
        self._law.allow(self._part * min(elapsed, LONGEST_GAP))

    def step_made(self, run: RunSettings, speed: float) -> None:
        """Note that a step of both runs was made. `speed`: simulated over wall time."""
        if self._law is not None:
            self._allowed = self._part * run.dt / speed / max(self._law.step_made(), 1)

    def close(self) -> None:
        """End its process, and give up its tests."""
        if self._law is not None:
            self._law.close()
        if self.examination is not None:
            self.examination.drop()
