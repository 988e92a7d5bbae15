"""Laws at equal safety in the present experiment: a curve a law over its own knob, computed in the background while it is shown."""

from collections.abc import Callable
from dataclasses import replace
from typing import Final, NamedTuple

from app.runtime.job_pool import Job, JobPool
from scenes.law_knobs import KNOBS, LawKnob, knob_points
from scenes.rerun import Stopped
from scenes.settings import RunSettings

SECONDS: Final = 12.0
"""Simulated time of a point [s]."""


class SafetyPoint(NamedTuple):
    """A run: smallest distance [m], and largest squared error [m² or rad²]."""

    d_min: float
    e2_max: float


def knob_curve(settings: RunSettings, knob: LawKnob, stopped: Callable[[], bool]) -> tuple[SafetyPoint, ...]:
    """Return the points of one knob, by their distance.

    Raises:
        Stopped: as soon as `stopped()` is true, after the run at work.
    """
    points: list[SafetyPoint] = []
    for point in knob_points(knob, settings, SECONDS):
        if stopped():
            raise Stopped
        points.append(SafetyPoint(point.summary.d_min, point.summary.e2_max))
    return tuple(sorted(points))


class SafetyCurves:
    """The curves of one session; computed when they are first asked for, and again when anything but the choice of law has changed.

    Args:
        background: where they are computed.
        wake: called when there is a further curve.
    """

    def __init__(self, background: JobPool, wake: Callable[[], None]) -> None:
        self._background, self._wake = background, wake
        self._of: RunSettings | None = None
        self._jobs: list[Job] = []

    def curves(self, run: RunSettings) -> dict[LawKnob, tuple[SafetyPoint, ...]]:
        """Return what is there already, curve by curve."""
        of = replace(run, law=replace(run.law, law="smooth_priority", feed_forward=False))
        if of != self._of:
            self.forget()
            self._of = of
            self._jobs = [self._background.submit(self, f"{knob}", knob_curve, of, knob, wake=self._wake) for knob in KNOBS]
        return {knob: job.result for knob, job in zip(KNOBS, self._jobs, strict=True) if job.result is not None}

    @property
    def size(self) -> float:
        """How much of it is there, from 0 to 1."""
        return sum(job.result is not None for job in self._jobs) / len(KNOBS)

    def forget(self) -> None:
        self._background.cancel(self)
        self._of, self._jobs = None, []
