"""Outcome of a run, for comparison: a hash of every step, and some whole steps."""

import hashlib
import json
import math
import zlib
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from controllers.errors import BadInputFile, LazyText
from controllers.kinematics import Array
from scenes.history import SCALARS, unit_of
from scenes.packing import planes_of, rows_of
from scenes.simulation import Simulation

MOST_ROWS: Final = 6_000
"""Most steps stored whole, evenly spread in a longer run; 30 s at the usual time step."""

CLOSE: Final = 1e-9
"""Largest difference of equal runs [SI]; other machines or libraries may give other last bits."""

KINDS: Final = frozenset({"pair", "authority", "joint", "authority_b", "joint_b"})

ARRAYS: Final = ("outcome_about", "outcome_hashes", "outcome_places", "outcome_rows")


@dataclass(frozen=True)
class RunOutcome:
    """Outcome of a run.

    Attributes:
        hashes: (steps,).
        places: (k,) steps stored whole, ascending, with the first and the last.
        rows: (k, columns).
    """

    columns: tuple[str, ...]
    digest: str
    hashes: np.ndarray
    places: np.ndarray
    rows: Array

    @property
    def steps(self) -> int:
        return len(self.hashes)


@dataclass(frozen=True)
class Difference:
    """One changed number.

    Attributes:
        step: from 0.
        time: simulated [s].
        then, now: nan if missing.
        by: [unit of the column], inf if one is missing.
    """

    step: int
    time: float
    column: str
    then: float
    now: float
    by: float

    def words(self, error_unit: str) -> LazyText:
        unit = unit_of(self.column, error_unit)
        if self.column in KINDS or math.isinf(self.by):
            what = LazyText(
                "{column} ({then:g} then, {now:g} now)", column=self.column, then=self.then, now=self.now
            )
        else:
            what = LazyText(
                "{column} by {by:.2g}{unit}", column=self.column, by=self.by, unit=f" {unit}" if unit else ""
            )
        return LazyText(
            "{what}, at step {number} (t = {time:.3f} s)", what=what, number=self.step + 1, time=self.time
        )


@dataclass(frozen=True)
class Comparison:
    """Two outcomes of the same inputs.

    Attributes:
        exact: equal bit for bit.
        first_step: first different one, from 0; None if unknown or equal.
        first: largest difference in the first stored different step.
        largest: of all stored steps.
    """

    exact: bool
    first_step: int | None
    first: Difference | None
    largest: Difference | None
    steps_then: int
    steps_now: int

    @property
    def close(self) -> bool:
        return self.steps_then == self.steps_now and (self.largest is None or self.largest.by <= CLOSE)


def history_columns(simulation: Simulation) -> tuple[str, ...]:
    """Columns of a history table: `scenes.history.SCALARS`, then "left_q1" …, "left_dq1" …, "left_qd1" …"""
    names = simulation.room.columns
    return (*SCALARS, *(name.format(kind) for kind in ("q", "dq", "qd") for name in names))


def outcome_of(table: Array, columns: tuple[str, ...]) -> RunOutcome:
    """Outcome of a history (steps ≥ 1, columns)."""
    table = _plain(table)
    stride = -(-len(table) // MOST_ROWS)
    places = np.unique(np.append(np.arange(0, len(table), stride), len(table) - 1)).astype(np.uint32)
    return RunOutcome(
        columns, hashlib.sha256(table.tobytes()).hexdigest(), _hashes(table), places, table[places]
    )


def compare_run(outcome: RunOutcome, table: Array, columns: tuple[str, ...]) -> Comparison:
    """Compare a repeated run (steps ≥ 1, columns) with the recorded one."""
    table = _plain(table)
    steps = len(table)
    if (
        columns == outcome.columns
        and steps == outcome.steps
        and hashlib.sha256(table.tobytes()).hexdigest() == outcome.digest
    ):
        return Comparison(True, None, None, None, steps, steps)
    first_step: int | None = None
    if columns == outcome.columns:
        common = min(steps, outcome.steps)
        unequal = np.flatnonzero(_hashes(table[:common]) != outcome.hashes[:common])
        first_step = int(unequal[0]) if len(unequal) else None
        if first_step is None and steps != outcome.steps:
            first_step = common
    kept = outcome.places < steps
    places = outcome.places[kept].astype(np.int64)
    shared = [name for name in outcome.columns if name in columns]
    then = outcome.rows[kept][:, [outcome.columns.index(name) for name in shared]]
    now = table[places][:, [columns.index(name) for name in shared]]
    with np.errstate(invalid="ignore"):
        by = np.abs(then - now)
    by[np.isnan(by)] = np.inf
    by[then.view(np.uint64) == now.view(np.uint64)] = 0.0
    times = now[:, shared.index("t")] if "t" in shared else np.zeros(len(places))

    def difference(row: int, column: int) -> Difference:
        a, b = float(then[row, column]), float(now[row, column])
        return Difference(int(places[row]), float(times[row]), shared[column], a, b, float(by[row, column]))

    rows = np.flatnonzero(by.max(axis=1, initial=0.0) > 0.0)
    if not len(rows):
        return Comparison(False, first_step, None, None, outcome.steps, steps)
    first = int(rows[0])
    row, column = (int(i) for i in np.unravel_index(int(by.argmax()), by.shape))
    return Comparison(
        False,
        first_step,
        difference(first, int(by[first].argmax())),
        difference(row, column),
        outcome.steps,
        steps,
    )


def _plain(table: Array) -> Array:
    """A table with one kind of nan, whose bits depend on the processor."""
    table = np.ascontiguousarray(table, "<f8").copy()
    table[np.isnan(table)] = np.nan
    return table


def _hashes(table: Array) -> np.ndarray:
    return np.array([zlib.crc32(row) for row in table], np.uint32)


# --- in a file


def outcome_arrays(outcome: RunOutcome) -> dict[str, np.ndarray]:
    about = json.dumps({"columns": outcome.columns, "digest": outcome.digest}).encode()
    parts = (
        np.frombuffer(about, np.uint8),
        outcome.hashes.astype("<u4"),
        outcome.places.astype("<u4"),
        planes_of(outcome.rows),
    )
    return dict(zip(ARRAYS, parts, strict=True))


def outcome_from(arrays: dict[str, np.ndarray], steps: int) -> RunOutcome:
    """Outcome from a file's parts `ARRAYS`. `steps`: of the recorded inputs.

    Raises:
        BadInputFile: damaged; the message is a part of a sentence.
    """
    about, hashes, places, packed = (arrays[name] for name in ARRAYS)
    try:
        parts: dict[str, Any] = json.loads(about.tobytes().decode())
        columns, digest = tuple(parts["columns"]), parts["digest"]
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise BadInputFile("says nothing of its outcome that can be read") from None
    fine = (
        isinstance(digest, str)
        and all(isinstance(part, np.ndarray) for part in (hashes, places, packed))
        and 0 < len(columns) <= 400
        and all(isinstance(name, str) and 0 < len(name) <= 40 and name.isprintable() for name in columns)
        and hashes.shape == (steps,)
        and hashes.dtype == places.dtype == np.dtype("<u4")
        and places.ndim == 1
        and 0 < len(places) <= MOST_ROWS + 1
        and (np.diff(places.astype(np.int64)) > 0).all()
        and int(places[-1]) == steps - 1
        and packed.dtype == np.uint8
        and packed.shape == (len(columns), 8, len(places))
    )
    if not fine:
        raise BadInputFile("has an outcome that does not belong to its inputs")
    return RunOutcome(columns, digest, hashes, places, rows_of(packed))
