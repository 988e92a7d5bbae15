"""The trade-off of n and v as a map of distance against error, computed in the background while it is shown."""

from collections.abc import Callable
from dataclasses import replace
from typing import Final

from app.runtime.job_pool import Job, JobPool
from scenes.rerun import Stopped
from scenes.settings import RunSettings
from scenes.sweep import TRADE_OFF_ORDERS, TradeOff, trade_off

SECONDS: Final = 12.0
"""Simulated time of a point [s]."""


def row(settings: RunSettings, order: float, stopped: Callable[[], bool]) -> tuple[TradeOff, ...]:
    """Return the points of one n, every v of the map.

    Raises:
        Stopped: as soon as `stopped()` is true, after the run at work.
    """
    points: list[TradeOff] = []
    for point in trade_off(settings, SECONDS, (order,)):
        if stopped():
            raise Stopped
        points.append(point)
    return tuple(points)


class TradeOffMap:
    """The map of one session; computed when it is first asked for, and again when anything but n and v has changed.

    Args:
        background: where it is computed.
        wake: called when there is a further row.
    """

    def __init__(self, background: JobPool, wake: Callable[[], None]) -> None:
        self._background, self._wake = background, wake
        self._of: RunSettings | None = None
        self._jobs: list[Job] = []

    def points(self, run: RunSettings) -> tuple[TradeOff, ...]:
        """Return what is there already, row by row; λ has an n only where the settings' law is asked with it."""
        of = replace(run, law=replace(run.law, order=1.0, nominal_velocity=0.1))
        if of != self._of:
            self.forget()
            self._of = of
            self._jobs = [
                self._background.submit(self, f"n = {order:g}", row, of, order, wake=self._wake) for order in TRADE_OFF_ORDERS
            ]
        return tuple(point for job in self._jobs if job.result is not None for point in job.result)

    @property
    def size(self) -> float:
        """How much of it is there, from 0 to 1."""
        return sum(job.result is not None for job in self._jobs) / len(TRADE_OFF_ORDERS)

    def forget(self) -> None:
        self._background.cancel(self)
        self._of, self._jobs = None, []
