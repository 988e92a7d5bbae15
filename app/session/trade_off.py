"""The trade-off of n and v as a map of distance against error, computed in the background while it is shown."""

from collections.abc import Callable
from dataclasses import replace
from typing import Final

from app.runtime.job_pool import Jobs
from app.session.background_parts import BackgroundParts
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


TradeOffMap = BackgroundParts[float, tuple[TradeOff, ...]]
"""One row an n."""


def trade_off_map(background: Jobs, wake: Callable[[], None]) -> TradeOffMap:
    """Return the map of a session; it does not depend on the present n and v. For the arguments see `BackgroundParts`."""
    return TradeOffMap(background, wake, TRADE_OFF_ORDERS, row, _any_order)


def _any_order(run: RunSettings) -> RunSettings:
    return replace(run, law=replace(run.law, order=1.0, nominal_velocity=0.1))
