"""A grid of settings run over a scene on all cores: the same figures whatever the number of workers; and the trade-off map."""

import math
from collections.abc import Iterator, Sequence
from typing import Final, NamedTuple

from scenes.children import computed
from scenes.grids import Axis, Grid
from scenes.headless import run
from scenes.robots.robot_files import given_at_start, take_over
from scenes.settings import RunSettings, changed

FIGURES: Final = ("d_min", "share_below", "e2_max", "e2_end", "dq_step_max", "ddq_max", "pair_switches", "out_of_authority_s")
"""What is kept of a run, as named in `scenes.headless.Summary`. No wall-clock times."""

Figures = tuple[float, ...]
"""In the order of `FIGURES`."""


def figures(settings: RunSettings, seconds: float) -> Figures:
    """Return the figures of a run of the scene with its own autopilot."""
    summary = run(settings, seconds).summary
    return tuple(getattr(summary, name) for name in FIGURES)


def run_points(grid: Grid, todo: Sequence[int], workers: int = 1) -> Iterator[tuple[int, Figures]]:
    """Yield (index, figures) of some points of a grid, each as soon as it is done: the figures of a point are always the same, the
    order is not, unless there is one worker.

    Args:
        todo: indices of points.
        workers: processes; with 1, everything runs in this one.

    Raises:
        DuetError: a worker was ended from outside.
    """
    points = grid.points()
    for place, found in computed(
        figures, [(grid.at(points[index]), grid.seconds) for index in todo], workers, (take_over, given_at_start())
    ):
        yield todo[place], found


class TradeOff(NamedTuple):
    """What the avoiding arm gets and what it pays, at one n and v.

    Attributes:
        order, nominal_velocity: n, and v [m/s].
        d_min: smallest distance [m].
        e2_max: largest squared error of the hand [m²].
    """

    order: float
    nominal_velocity: float
    d_min: float
    e2_max: float


TRADE_OFF_ORDERS: Final = (1.0, 2.0, 4.0, 8.0, 16.0)
TRADE_OFF_VELOCITIES: Final = (0.1, 0.2, 0.3, 0.45, 0.7)
"""[m/s]"""


def trade_off(
    settings: RunSettings,
    seconds: float = 12.0,
    orders: Sequence[float] = TRADE_OFF_ORDERS,
    velocities: Sequence[float] = TRADE_OFF_VELOCITIES,
) -> Iterator[TradeOff]:
    """Yield distance against error over a grid of n and v in the hold scene, a point a run, spread so that the first show the whole map.

    Args:
        settings: everything but n, v and the scene.
        seconds: simulated time of a point.
    """
    settings = changed(settings, "scene", "hold")
    grid = Grid(settings, (Axis("n", tuple(orders)), Axis("v", tuple(velocities))), seconds)
    points = grid.points()
    for index in spread(len(points)):
        order, velocity = points[index]
        summary = run(grid.at(points[index]), seconds).summary
        yield TradeOff(order, velocity, summary.d_min, summary.e2_max)


def spread(count: int) -> list[int]:
    """Return 0 … count − 1, each once, in an order in which the first few already lie all over the range."""
    stride = max(1, round(count * 0.381966))
    while math.gcd(stride, count) != 1:
        stride += 1
    return [i * stride % count for i in range(count)]
