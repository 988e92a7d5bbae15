"""Signals over time in bins that keep what is seen of them: the extremes, the largest single step, and the newest value."""

from itertools import pairwise
from typing import Final

import numpy as np

from controllers.kinematics import Array

WINDOW: Final = 20.0
"""Length of the time axis [s]."""

POINTS: Final = 160
"""Bins of the time axis."""

LAST, LOW, HIGH, FROM, TO, AT_LOW, AT_HIGH, BEFORE, AFTER, COUNT = range(10)
"""What a bin keeps of a signal: its newest value, the extremes, the values on both sides of the largest step, when they were [s], and the
number of values."""

_VALUES: Final = [LOW, HIGH, FROM, TO]
_TIMES: Final = [AT_LOW, AT_HIGH, BEFORE, AFTER]

STEEP: Final = 3.0
"""A step is one, and no motion, if it is more than so many times what the signal does in a step on average."""

_SPANS: Final = (1, 2, 4)
"""Half of how many bins a straight piece may lie over, in the order in which it grows."""


class Bins:
    """The last 20 s of some signals.

    Args:
        columns: number of signals.
    """

    def __init__(self, columns: int) -> None:
        self._stats = np.full((POINTS, COUNT + 1, columns), np.nan)
        self._ends = np.full(POINTS, np.nan)
        self._row: tuple[float, Array] | None = None
        self._range = np.arange(columns)
        self.newest = -1
        """Number of the newest bin, counted from time 0; −1 if there is none."""

    def clear(self) -> None:
        self._stats[:], self._ends[:] = np.nan, np.nan
        self.newest, self._row = -1, None

    def take(self, times: Array, values: Array) -> None:
        """Take in what comes next.

        Args:
            times: (rows,) ascending [s].
            values: (rows, columns), nan where there is nothing.
        """
        time, row = self._row or (float(times[0]), values[0])
        before_times, before = np.concatenate([[time], times[:-1]]), np.concatenate([row[None], values[:-1]])
        with np.errstate(invalid="ignore"):
            steps = np.abs(values - before)
        steps[~np.isfinite(steps)] = 0.0
        numbers = bin_numbers(times)
        edges = [0, *(np.flatnonzero(np.diff(numbers)) + 1).tolist(), len(numbers)]
        for begin, end in pairwise(edges):
            number, rows = int(numbers[begin]), slice(begin, end)
            # A long step may jump over a bin; what is left in the ring from 20 s ago must go.
            for skipped in range(max(self.newest + 1, number - POINTS + 1), number + 1):
                self._stats[skipped % POINTS], self._ends[skipped % POINTS] = np.nan, np.nan
            self.newest = number
            self._ends[number % POINTS] = times[end - 1]
            self._fill(self._stats[number % POINTS], times[rows], values[rows], before_times[rows], before[rows], steps[rows])
        self._row = float(times[-1]), values[-1].copy()

    def _fill(self, b: Array, times: Array, values: Array, before_times: Array, before: Array, steps: Array) -> None:
        every = self._range
        for kept, at, sign in ((LOW, AT_LOW, 1.0), (HIGH, AT_HIGH, -1.0)):
            signed = sign * values
            rows = np.where(np.isnan(signed), np.inf, signed).argmin(axis=0)
            found = values[rows, every]
            better = np.isnan(b[kept]) | (sign * found < sign * b[kept])
            b[kept, better], b[at, better] = found[better], times[rows][better]
        rows = steps.argmax(axis=0)
        largest = steps[rows, every]
        better = (largest > 0.0) & ~(np.abs(b[TO] - b[FROM]) >= largest)
        b[FROM, better], b[TO, better] = before[rows, every][better], values[rows, every][better]
        b[BEFORE, better], b[AFTER, better] = before_times[rows][better], times[rows][better]
        b[LAST] = values[-1]
        b[COUNT] = np.where(np.isnan(b[COUNT]), 0.0, b[COUNT]) + len(times)

    @property
    def numbers(self) -> np.ndarray:
        """Numbers of the bins that hold something, oldest first."""
        numbers = np.arange(max(self.newest - POINTS + 1, 0), self.newest + 1)
        return numbers[~np.isnan(self._ends[numbers % POINTS])]

    def ends(self, numbers: np.ndarray) -> Array:
        """Return the time of the newest value of each bin [s]."""
        return self._ends[numbers % POINTS]

    def at(self, numbers: np.ndarray, columns: list[int], leader: Array | None = None) -> Array:
        """Return what is kept of some signals in bins (bins, what is kept, signals); nan where there is nothing.

        Args:
            leader: what stands before the first bin, of the same shape; None for nan.
        """
        found = self._stats[numbers % POINTS][:, :, columns]
        own = self.numbers
        found[~np.isin(numbers, own)] = np.nan
        if leader is not None:
            before = numbers < own[0] if len(own) else np.full(len(numbers), True)
            found[before] = leader[before]
        return found


def bin_numbers(times: Array) -> np.ndarray:
    """Return the number of the bin of each time [s]."""
    return (times * (POINTS / WINDOW)).astype(int)


def polyline(numbers: np.ndarray, ends: Array, stats: Array, tolerance: float) -> tuple[Array, Array]:
    """Return the corners of the lines that show signals: few where they are straight, and all that is seen where they are not.

    No value of a bin lies farther beyond the line than the tolerance, and no step that is larger is drawn as a slope. Where several signals
    step in one bin, all edges stand at the one that steps most.

    Args:
        numbers: (k,) of the bins, ascending.
        ends: (k,) time of the newest value of each bin [s].
        stats: (k, what is kept, signals), see `Bins.at`.
        tolerance: what cannot be seen, in the unit of the signals.

    Returns:
        Times (m,), not descending, and values (m, signals).
    """
    last, low, high = stats[:, LAST], stats[:, LOW], stats[:, HIGH]
    before = np.concatenate([last[:1], last[:-1]])
    before = np.where(np.isnan(before), last, before)
    with np.errstate(invalid="ignore"):
        outside = np.maximum(high - np.maximum(last, before), np.minimum(last, before) - low)
        steps = np.abs(stats[:, TO] - stats[:, FROM])
        steep = (steps > tolerance) & (steps * stats[:, COUNT] > STEEP * (high - low))
        shown = steep | (outside > tolerance)
        moving = np.maximum(high, before) - np.minimum(low, before) > tolerance / 2.0
    wide = np.asarray(shown.any(axis=1))
    kept = ~_straight(numbers, ends, last, ~wide, tolerance / 4.0)
    # Between two bins with corners of every signal that moves the end of the first one adds nothing.
    done = shown | ~moving
    kept[:-1] &= ~((done[:-1] & done[1:]).all(axis=1) & wide[:-1] & wide[1:])
    rows = np.flatnonzero(wide)
    if not len(rows):
        return ends[kept], last[kept]
    times, values = _corners(
        ends, stats, before, shown, np.where(steep, steps, 0.0) + np.where(shown, outside, 0.0), rows, tolerance
    )
    # The corners of a bin stand before its end.
    places = np.concatenate([5 * np.flatnonzero(kept) + 4, (5 * rows[:, None] + np.arange(4)).ravel()])
    order = places.argsort(kind="stable")
    times = np.concatenate([ends[kept], times.ravel()])[order]
    values = np.concatenate([last[kept], values.reshape(-1, last.shape[1])])[order]
    same = (values[1:] == values[:-1]) | (np.isnan(values[1:]) & np.isnan(values[:-1]))
    other = np.concatenate([~(same.all(axis=1) & (times[1:] == times[:-1])), [True]])
    return times[other], values[other]


def _corners(
    ends: Array, stats: Array, before: Array, shown: np.ndarray, sizes: Array, rows: np.ndarray, tolerance: float
) -> tuple[Array, Array]:
    """Return four times (bins, 4) in each of the bins `rows`, and all signals at them (bins, 4, signals)."""
    times, values = stats[rows][:, _TIMES], stats[rows][:, _VALUES]
    low, high, begin, end = np.moveaxis(values, 1, 0)
    with np.errstate(invalid="ignore"):
        whole = (np.minimum(begin, end) <= low + tolerance) & (np.maximum(begin, end) >= high - tolerance)
    # Two corners are enough without a step, or if the step of every signal is all that it does.
    whole = (whole | ~shown[rows]).all(axis=1)[:, None] & ~np.isnan(begin)
    still = np.isnan(begin)
    for extreme, edge in ((0, 2), (1, 3)):
        times[:, extreme][whole], values[:, extreme][whole] = times[:, edge][whole], values[:, edge][whole]
        times[:, edge][still], values[:, edge][still] = times[:, extreme][still], values[:, extreme][still]
    order = times.argsort(axis=1, kind="stable")
    times, values = np.take_along_axis(times, order, axis=1), np.take_along_axis(values, order, axis=1)
    times = times[np.arange(len(rows)), :, np.nan_to_num(sizes[rows], nan=-1.0, posinf=-1.0).argmax(axis=1)]
    begins = ends[np.maximum(rows - 1, 0)]
    share = (times - begins[:, None]) / np.maximum(ends[rows] - begins, 1e-9)[:, None]
    begin, end = before[rows][:, None], stats[rows, LAST][:, None]
    with np.errstate(invalid="ignore"):
        # Infinity minus infinity is not 0.
        straight = np.where(begin == end, end, begin + share[:, :, None] * (end - begin))
    return times, np.where(shown[rows][:, None], values, straight)


def _straight(numbers: np.ndarray, ends: Array, last: Array, calm: np.ndarray, tolerance: float) -> np.ndarray:
    """Return which bins (k,) lie on a straight line between others. `calm`: bins (k,) that may."""
    gone = np.zeros(len(ends), bool)
    for span in _SPANS:
        # By the bin's own number, so that a corner stays while the window moves.
        middle = np.flatnonzero(calm & (numbers % (2 * span) == span))
        middle = middle[(middle >= span) & (middle < len(ends) - span)]
        left, right = middle - span, middle + span
        alike = calm[right] & (numbers[right] - numbers[left] == 2 * span)
        if span > 1:
            alike = alike & gone[middle - span // 2] & gone[middle + span // 2]
        middle, left, right = middle[alike], left[alike], right[alike]
        share = (ends[middle] - ends[left]) / (ends[right] - ends[left])
        with np.errstate(invalid="ignore"):
            off = np.abs(last[left] + share[:, None] * (last[right] - last[left]) - last[middle])
        nothing = np.isnan(last[left]) & np.isnan(last[middle]) & np.isnan(last[right])
        equal = (last[left] == last[middle]) & (last[right] == last[middle])
        gone[middle[((off <= tolerance) | nothing | equal).all(axis=1)]] = True
    return gone
