"""A long run in few rows, for a picture: steps of the run itself, chosen so that every dip, every peak and every jump is among them."""

from itertools import pairwise
from typing import Final

import numpy as np

from app.plots.bins import STEEP
from controllers.kinematics import Array
from scenes.history import COLUMN, SCALARS

POINTS: Final = 3_200
"""Of a line at most; each of them is a step of the run."""

BINS: Final = 400
"""Pieces of a longer run of which the same number of points is kept: the ends, and the steps that lie off a line between them."""

VISIBLE: Final = 1.0 / 600.0
"""Share of a signal's range from which on a step off the line is seen."""

_FIRST: Final = (COLUMN["d"], COLUMN["e2"])
"""Their extremes are kept whatever else there is."""

_HIDDEN: Final = [COLUMN[name] for name in SCALARS if name not in ("d", "lambda", "e2", "u", "w", "e2_b")]
"""Columns of no plot over time, or of strips."""


def thinned_table(table: Array) -> tuple[Array, np.ndarray]:
    """Return at most `POINTS` rows of a table, and which ones they are (k,): extremes and jumps of every signal are among them."""
    count = len(table)
    if count <= POINTS:
        return table, np.arange(count)
    finite = np.where(np.isfinite(table), table, np.nan)
    known = np.delete(np.arange(table.shape[1]), _HIDDEN)
    known = known[~np.isnan(finite[:, known]).all(axis=0)]
    ranges = np.nanmax(finite[:, known], axis=0) - np.nanmin(finite[:, known], axis=0)
    moving, ranges = known[ranges > 0.0], ranges[ranges > 0.0]
    seen, first = finite[:, moving] / ranges, np.flatnonzero(np.isin(moving, _FIRST))
    edges = np.unique(np.linspace(0, count - 1, BINS + 1).astype(int))
    kept = [edges]
    for begin, end in pairwise(edges.tolist()):
        piece = np.nan_to_num(seen[begin : end + 1])
        if len(piece) > 2:
            kept.append(begin + _corners(piece, first))
    rows = np.unique(np.concatenate(kept))
    return table[rows], rows


def _corners(piece: Array, first: np.ndarray) -> np.ndarray:
    """Return the rows of a piece that lie farthest off the line between its ends, or next to a jump; at most `POINTS` / `BINS` − 1.

    Args:
        piece: signals (rows, columns) over their range.
        first: columns of which the extremes come first.
    """
    steps, every = np.abs(np.diff(piece, axis=0)), np.arange(piece.shape[1])
    off = piece - (piece[0] + np.linspace(0.0, 1.0, len(piece))[:, None] * (piece[-1] - piece[0]))
    worth: dict[int, float] = {}
    jumps = steps.argmax(axis=0)
    sizes = steps[jumps, every]
    jump = (sizes > VISIBLE) & (sizes * len(piece) > STEEP * np.ptp(piece, axis=0))
    for column, row in zip(every[jump].tolist(), jumps[jump].tolist(), strict=True):
        for place in (row, row + 1):
            worth[place] = max(worth.get(place, 0.0), float(sizes[column]))
    for rows in (piece.argmin(axis=0), piece.argmax(axis=0)):
        far = np.abs(off[rows, every])
        far[first] *= 1e6
        for column, row in zip(every[far > VISIBLE].tolist(), rows[far > VISIBLE].tolist(), strict=True):
            worth[row] = max(worth.get(row, 0.0), float(far[column]))
    return np.array(sorted(worth, key=lambda row: -worth[row])[: POINTS // BINS - 1], int)
