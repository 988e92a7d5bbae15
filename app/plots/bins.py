"""Signals in bins of time."""

from itertools import pairwise
from typing import Final

import numpy as np

from app.session.replay import PERIOD
from controllers.kinematics import Array

WINDOW: Final = 20.0
"""Length of the time axis [s]."""

BIN: Final = 4.0 * PERIOD
"""Length of a bin [s]."""

POINTS: Final = round(WINDOW / BIN)

LAST, LOW, HIGH, FROM, TO, AT_LOW, AT_HIGH, BEFORE, AFTER, COUNT = range(10)
"""Statistics of a bin: newest value, extremes, values around the largest step, times of these four [s],
number of values.
"""

_VALUES: Final = slice(LOW, TO + 1)
_TIMES: Final = slice(AT_LOW, AFTER + 1)
_EXTREMES: Final = slice(LOW, HIGH + 1)
_SIGNS: Final = np.array([[1.0], [-1.0]])

STEEP: Final = 3.0
"""A jump is larger than this many average differences."""

_SPANS: Final = (1, 2, 4)
"""Half-lengths of straight pieces [bins]."""


class Bins:
    def __init__(self, columns: int) -> None:
        # A signal's bins are adjacent: a few signals are computed for all bins at once.
        self._stats = np.full((COUNT + 1, columns, POINTS), np.nan)
        self._ends = np.full(POINTS, np.nan)
        self._row: tuple[float, Array] | None = None
        self._range = np.arange(columns)
        self.newest = -1
        """Newest bin, counted from time 0; −1 without one."""

    def take(self, times: Array, values: Array) -> None:
        """Add rows: ascending times (rows,) [s] and values (rows, columns), nan if missing."""
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
                self._stats[:, :, skipped % POINTS], self._ends[skipped % POINTS] = np.nan, np.nan
            self.newest = number
            self._ends[number % POINTS] = times[end - 1]
            bin_ = self._stats[:, :, number % POINTS]
            self._fill(bin_, times[rows], values[rows], before_times[rows], before[rows], steps[rows])
        self._row = float(times[-1]), values[-1].copy()

    def _fill(
        self, b: Array, times: Array, values: Array, before_times: Array, before: Array, steps: Array
    ) -> None:
        every = self._range
        signed = np.stack([values, -values])
        signed[np.isnan(signed)] = np.inf
        rows = signed.argmin(axis=1)
        found, kept = values[rows, every], b[_EXTREMES]
        better = np.isnan(kept) | (_SIGNS * found < _SIGNS * kept)
        np.copyto(kept, found, where=better)
        np.copyto(b[AT_LOW : AT_HIGH + 1], times[rows], where=better)
        rows = steps.argmax(axis=0)
        largest = steps[rows, every]
        better = (largest > 0.0) & ~(np.abs(b[TO] - b[FROM]) >= largest)
        if better.any():
            b[FROM, better], b[TO, better] = before[rows, every][better], values[rows, every][better]
            b[BEFORE, better], b[AFTER, better] = before_times[rows][better], times[rows][better]
        b[LAST] = values[-1]
        b[COUNT] = np.where(np.isnan(b[COUNT]), 0.0, b[COUNT]) + len(times)

    @property
    def numbers(self) -> np.ndarray:
        numbers = np.arange(max(self.newest - POINTS + 1, 0), self.newest + 1)
        return numbers[~np.isnan(self._ends[numbers % POINTS])]

    def ends(self, numbers: np.ndarray) -> Array:
        """Times of the newest values [s]."""
        return self._ends[numbers % POINTS]

    def at(self, numbers: np.ndarray, columns: list[int], leader: Array | None = None) -> Array:
        """Statistics (statistics, signals, bins), nan in empty bins. `leader`: the same before the first bin;
        None for nan.
        """
        found = self._stats[:, columns][:, :, numbers % POINTS]
        own = self.numbers
        if not np.array_equal(numbers, own):
            found[:, :, ~np.isin(numbers, own)] = np.nan
            if leader is not None:
                before = numbers < own[0] if len(own) else np.full(len(numbers), True)
                found[:, :, before] = leader[:, :, before]
        return found


def bin_numbers(times: Array) -> np.ndarray:
    """Bin number of each time [s]."""
    return (times * (POINTS / WINDOW)).astype(int)


def begin_of(number: int) -> float:
    """Beginning of a bin [s]."""
    return number * (WINDOW / POINTS)


def polyline(numbers: np.ndarray, ends: Array, stats: Array, tolerance: float) -> tuple[Array, Array]:
    """Corners of lines: few on straight pieces, all visible detail elsewhere.

    Every value is within the tolerance of its line, and a larger step is an edge. If several signals step in
    one bin, all edges are at the largest step.

    Args:
        numbers, ends: (k,), ascending, see `Bins`.
        stats: (statistics, signals, k).
        tolerance: [unit of the signals].

    Returns:
        Times (m,), not descending, and values (signals, m).
    """
    last, low, high = stats[LAST], stats[LOW], stats[HIGH]
    before = np.concatenate([last[:, :1], last[:, :-1]], axis=1)
    before = np.where(np.isnan(before), last, before)
    # Some signals are unknown, and infinity minus infinity is not 0.
    with np.errstate(invalid="ignore"):
        outside = np.maximum(high - np.maximum(last, before), np.minimum(last, before) - low)
        steps = np.abs(stats[TO] - stats[FROM])
        steep = (steps > tolerance) & (steps * stats[COUNT] > STEEP * (high - low))
        shown = steep | (outside > tolerance)
        moving = np.maximum(high, before) - np.minimum(low, before) > tolerance / 2.0
        wide = np.asarray(shown.any(axis=0))
        kept = ~_straight(numbers, ends, last, ~wide, tolerance / 4.0)
        # Between two bins with corners of every signal that moves the end of the first one adds nothing.
        done = (shown | ~moving).all(axis=0) & wide
        kept[:-1] &= ~(done[:-1] & done[1:])
        rows = np.flatnonzero(wide)
        if not len(rows):
            return ends[kept], last[:, kept]
        sizes = np.where(steep, steps, 0.0) + np.where(shown, outside, 0.0)
        times, values = _corners(ends, stats[:, :, rows], before, shown, sizes, rows, tolerance)
    # The corners of a bin precede its end.
    places = np.concatenate([5 * np.flatnonzero(kept) + 4, (5 * rows[:, None] + np.arange(4)).ravel()])
    order = places.argsort(kind="stable")
    times = np.concatenate([ends[kept], times.T.ravel()])[order]
    values = np.concatenate([last[:, kept], values.transpose(1, 2, 0).reshape(len(last), -1)], axis=1)[
        :, order
    ]
    same = (values[:, 1:] == values[:, :-1]) | (np.isnan(values[:, 1:]) & np.isnan(values[:, :-1]))
    other = np.concatenate([~(same.all(axis=0) & (times[1:] == times[:-1])), [True]])
    return times[other], values[:, other]


def _corners(
    ends: Array,
    stats: Array,
    before: Array,
    shown: np.ndarray,
    sizes: Array,
    rows: np.ndarray,
    tolerance: float,
) -> tuple[Array, Array]:
    """Times (4, bins) and signals (4, signals, bins) in the bins `rows`; `stats`: only of these."""
    times, values = stats[_TIMES], stats[_VALUES]
    low, high, begin, end = values
    whole = (np.minimum(begin, end) <= low + tolerance) & (np.maximum(begin, end) >= high - tolerance)
    still, shown = np.isnan(begin), shown[:, rows]
    # Two corners are enough without a step, or if the step of every signal is all that it does.
    whole = (whole | ~shown).all(axis=0) & ~still
    for extreme, edge in ((0, 2), (1, 3)):
        for kept in (times, values):
            np.copyto(kept[extreme], kept[edge], where=whole)
            np.copyto(kept[edge], kept[extreme], where=still)
    order, signals, bins = (
        times.argsort(axis=0, kind="stable"),
        np.arange(len(before))[:, None],
        np.arange(len(rows)),
    )
    times, values = times[order, signals, bins], values[order, signals, bins]
    sizes = sizes[:, rows]
    times = times[:, np.where(np.isfinite(sizes), sizes, -1.0).argmax(axis=0), bins]
    begins = ends[np.maximum(rows - 1, 0)]
    share = (times - begins) / np.maximum(ends[rows] - begins, 1e-9)
    begin, end = before[:, rows], stats[LAST]
    straight = np.where(begin == end, end, begin + share[:, None] * (end - begin))
    return times, np.where(shown, values, straight)


def _straight(
    numbers: np.ndarray, ends: Array, last: Array, calm: np.ndarray, tolerance: float
) -> np.ndarray:
    """Mask (k,) of bins on a straight line. `calm`: candidates (k,)."""
    count, first = len(numbers), int(numbers[0])
    if int(numbers[-1]) - first + 1 != count:
        # Long steps have jumped over bins: those in between are there, and not calm.
        full = np.arange(first, int(numbers[-1]) + 1)
        every_end, every_last, every_calm = (
            np.full(len(full), np.nan),
            np.full((len(last), len(full)), np.nan),
            full < 0,
        )
        there = numbers - first
        every_end[there], every_last[:, there], every_calm[there] = ends, last, calm
        return _straight(full, every_end, every_last, every_calm, tolerance)[there]
    gone, finite = np.zeros(count, bool), bool(np.isfinite(last).all())
    for span in _SPANS:
        # By the bin's own number, so that a corner stays while the window moves.
        at = span + -first % (2 * span)
        if at >= count - span:
            break
        left, middle, right = (
            slice(at + shift, count - span + shift, 2 * span) for shift in (-span, 0, span)
        )
        alike = calm[middle] & calm[right]
        if span > 1:
            for shift in (-span // 2, span // 2):
                alike &= gone[at + shift : count - span + shift : 2 * span]
        begin, here, end = last[:, left], last[:, middle], last[:, right]
        share = (ends[middle] - ends[left]) / (ends[right] - ends[left])
        level = np.abs(begin + share * (end - begin) - here) <= tolerance
        if not finite:
            level |= np.isnan(begin) & np.isnan(here) & np.isnan(end)
            level |= (begin == here) & (end == here)
        gone[middle] = alike & level.all(axis=0)
    return gone
