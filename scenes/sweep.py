"""A grid of settings, run on all cores; the figures do not depend on the number of workers."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, Final, NamedTuple

from controllers.errors import BadSetting
from scenes.children import ComputeMany, computed
from scenes.headless import check_length, run
from scenes.settings import RunSettings, changed, named_values, specs, validate, values

FORMS: Final = "write key=a:b (steps of 1), key=a:b:count (evenly spaced) or key=x,y,z"

MOST_POINTS: Final = 20_000
"""Largest grid; a point takes about a second."""

Point = tuple[Any, ...]


@dataclass(frozen=True)
class Axis:
    """A setting and its checked values, in order."""

    key: str
    values: tuple[Any, ...]


@dataclass(frozen=True)
class Grid:
    """All combinations of the axes' values; the last axis varies fastest.

    Attributes:
        axes: at least one, with different keys.
        seconds: simulated time of a point.
    """

    settings: RunSettings
    axes: tuple[Axis, ...]
    seconds: float

    @property
    def shape(self) -> tuple[int, ...]:
        return tuple(len(axis.values) for axis in self.axes)

    @property
    def size(self) -> int:
        return math.prod(self.shape)

    def points(self) -> list[Point]:
        return list(product(*(axis.values for axis in self.axes)))

    def at(self, point: Point) -> RunSettings:
        settings = self.settings
        for axis, value in zip(self.axes, point, strict=True):
            settings = changed(settings, axis.key, value)
        return settings

    def fixed(self) -> dict[str, Any]:
        """Key → value of the settings that do not vary."""
        swept = {axis.key for axis in self.axes}
        return {key: value for key, value in named_values(self.settings).items() if key not in swept}


def read_grid(settings: RunSettings, over: Sequence[str], seconds: float) -> Grid:
    """Grid of texts as in `read_axis`; every point can be run.

    Raises:
        BadSetting: a text, value or combination is not possible, or the grid or a run is too large.
    """
    if not over:
        raise BadSetting(f"A sweep needs a setting to sweep: give --over at least once; {FORMS}.")
    axes = tuple(read_axis(text, settings) for text in over)
    keys = [axis.key for axis in axes]
    for key in keys:
        if keys.count(key) > 1:
            raise BadSetting(f"over: {key} is swept twice; list all its values in one --over {key}=….")
    grid = Grid(settings, axes, seconds)
    if grid.size > MOST_POINTS:
        raise BadSetting(
            f"over: the grid has {grid.size} points; take fewer values, at most {MOST_POINTS} points in all."
        )
    _rehearse(grid)
    return grid


def _rehearse(grid: Grid) -> None:
    """Check every point, with one step for each combination of choices."""
    numbers = {axis.key for axis in grid.axes if is_scale(axis)}
    seen: set[Point] = set()
    for point in grid.points():
        settings = validate(grid.at(point))
        check_length(settings, grid.seconds)
        choices = tuple(
            value for axis, value in zip(grid.axes, point, strict=True) if axis.key not in numbers
        )
        if choices not in seen:
            seen.add(choices)
            run(settings, settings.dt)


def is_scale(axis: Axis) -> bool:
    return not isinstance(axis.values[0], (str, bool))


def read_axis(text: str, settings: RunSettings) -> Axis:
    """Axis of a text.

    Args:
        text: `key=a:b` for a, a + 1 … b; `key=a:b:count` for evenly spaced values with both ends; `key=x,y,z`
            for a list, the only form of choices and flags; `;` separates curves.

    Raises:
        BadSetting: the text cannot be read, or a value is not possible.
    """
    key, equals, body = text.partition("=")
    key = key.strip().replace("-", "_")
    if not equals or not key or not body.strip():
        raise BadSetting(
            f"over = {text!r} cannot be read; {FORMS}, as in n=1:20, v=0.05:0.6:12 or law=smooth_priority,unprotected."
        )
    known = specs(type(settings))
    if key not in known:
        raise BadSetting(f"over: There is no setting {key!r}; choose from {', '.join(known)}.")
    text_of_points = known[key].read is not None
    parts = [part.strip() for part in body.split(":")]
    if text_of_points or len(parts) == 1:
        wanted: list[Any] = [part.strip() for part in body.split(";" if text_of_points else ",")]
    elif isinstance(values(settings)[key], (str, bool)):
        raise BadSetting(
            f"over = {text!r}: {key} is not a number; list its values, as in {key}={','.join(known[key].choices) or '0,1'}."
        )
    else:
        wanted = _range(text, parts)
    found = tuple(values(changed(settings, key, value))[key] for value in wanted)
    if len(set(found)) < len(found):
        raise BadSetting(f"over = {text!r} names a value twice; name each once.")
    return Axis(key, found)


def _range(text: str, parts: list[str]) -> list[float]:
    try:
        first, last, *more = (float(part) for part in parts)
    except ValueError:
        raise BadSetting(f"over = {text!r}: a, b and count must be numbers; {FORMS}.") from None
    if len(more) > 1 or not all(map(math.isfinite, (first, last, *more))):
        raise BadSetting(f"over = {text!r} cannot be read; {FORMS}.")
    if not first < last:
        raise BadSetting(
            f"over = {text!r}: a range goes upwards, and {first:g} is not below {last:g}; {FORMS}."
        )
    if not more:
        if first % 1.0 or last % 1.0:
            raise BadSetting(
                f"over = {text!r}: steps of 1 need whole numbers at both ends; add a count, as in {text}:12."
            )
        count = last - first + 1.0
    else:
        count = more[0]
        if count % 1.0 or count < 2.0:
            raise BadSetting(
                f"over = {text!r}: the count must be a whole number from 2, not {count:g}; {FORMS}."
            )
    if count > MOST_POINTS:
        raise BadSetting(f"over = {text!r} has {count:g} values; take at most {MOST_POINTS}.")
    intervals = int(count) - 1
    # Twelve digits: 0.15, not 0.15000000000000002.
    return [float(f"{first + (last - first) * (i / intervals):.12g}") for i in range(intervals + 1)]


FIGURES: Final = (
    "d_min",
    "share_below",
    "e2_max",
    "e2_end",
    "dq_step_max",
    "ddq_max",
    "pair_switches",
    "out_of_authority_s",
)
"""Figures of `scenes.headless.Summary` without wall-clock times."""

SweepFigures = tuple[float, ...]


def sweep_figures(settings: RunSettings, seconds: float) -> SweepFigures:
    summary = run(settings, seconds).summary
    return tuple(getattr(summary, name) for name in FIGURES)


def run_points(
    grid: Grid, todo: Sequence[int], compute: ComputeMany[SweepFigures] = computed
) -> Iterator[tuple[int, SweepFigures]]:
    """Yield (index, figures) of some points, each when done.

    Args:
        compute: runs them; by default in this process, in order.

    Raises:
        DuetError: a worker was ended from outside, or as `compute` does.
    """
    points = grid.points()
    for place, found in compute(sweep_figures, [(grid.at(points[index]), grid.seconds) for index in todo]):
        yield todo[place], found


class TradeOff(NamedTuple):
    """Result at one n and v.

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


def trade_off(settings: RunSettings, seconds: float, order: float) -> Iterator[TradeOff]:
    """Results at one n and every v. `seconds`: simulated time of a point."""
    settings = changed(settings, "n", order)
    for velocity in TRADE_OFF_VELOCITIES:
        summary = run(changed(settings, "v", velocity), seconds).summary
        yield TradeOff(order, velocity, summary.d_min, summary.e2_max)
