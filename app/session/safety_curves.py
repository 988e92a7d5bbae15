"""Laws at equal safety in the present experiment: a curve a law over its own knob, computed in the background while it is shown."""

from collections.abc import Callable
from dataclasses import replace
from typing import Final, NamedTuple

from app.runtime.job_pool import Jobs
from app.session.background_parts import BackgroundParts
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


SafetyCurves = BackgroundParts[LawKnob, tuple[SafetyPoint, ...]]
"""One curve a knob."""


def safety_curves(background: Jobs, wake: Callable[[], None]) -> SafetyCurves:
    """Return the curves of a session; they do not depend on the chosen law. For the arguments see `BackgroundParts`."""
    return SafetyCurves(background, wake, KNOBS, knob_curve, _any_law)


def _any_law(run: RunSettings) -> RunSettings:
    return replace(run, law=replace(run.law, law="smooth_priority", feed_forward=False))
