"""Targets of a hand, and the resulting motion, as CSV."""

import contextlib
import csv
import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final, TextIO

import numpy as np
import pinocchio as pin

from controllers.errors import BadInputFile
from controllers.kinematics import Array
from scenes.csv_reading import (
    TextRow,
    TextTable,
    cells_of,
    has_decimal_commas,
    number_in_cell,
    read_text_table,
    separator_of,
)
from scenes.files import input_content
from scenes.history import COLUMN, unit_of
from scenes.simulation import Simulation
from scenes.targets import HandTarget, between

POSITION_HEADER: Final = ("t", "x", "y", "z")
POSE_HEADER: Final = (*POSITION_HEADER, "qw", "qx", "qy", "qz")
REACH: Final = 10.0
"""Largest plausible coordinate of a hand [m]."""
LENGTHS: Final = (
    ("centimetres", "100", 200.0),
    ("millimetres", "1000", 10_000.0),
    ("micrometres", "1000000", 1e7),
)
"""Other possible units: name, divisor and largest plausible number."""
MOST_BYTES: Final = 64_000_000


class Recording:
    """Path of a hand: straight between samples, at rest after the last.

    Args:
        times: (k,) [s], strictly increasing.
        positions: (k, 3) world [m].
        quaternions: (k, 4) as w, x, y, z of unit length; None if only the position matters.
    """

    def __init__(self, times: Array, positions: Array, quaternions: Array | None = None) -> None:
        self.times, self.positions = times, positions
        self._rotations = (
            None if quaternions is None else [pin.Quaternion(w, x, y, z) for w, x, y, z in quaternions]
        )

    def target(self, time: float) -> HandTarget:
        i, j, part = between(self.times, time)
        position = self.positions[i] + (self.positions[j] - self.positions[i]) * part
        if self._rotations is None:
            return HandTarget(position)
        return HandTarget(position, self._rotations[i].slerp(part, self._rotations[j]).toRotationMatrix())


def read_inputs(path: Path) -> Recording:
    """Recording of a CSV file, see `inputs_from`.

    Raises:
        BadInputFile: no such file, or not such a file; names the line.
    """
    return inputs_from(input_content(path, MOST_BYTES), str(path))


def inputs_from(data: bytes, path: str) -> Recording:
    """Recording of CSV content in any form of `scenes.csv_reading`.

    The header is `t,x,y,z` or `t,x,y,z,qw,qx,qy,qz`, perhaps with SI units, as in `t [s]`.

    Raises:
        BadInputFile: not such a file; names line and column.
    """
    table = read_text_table(data, path, "give a CSV file with the header t,x,y,z")
    header, rows = _header(path, table)
    if not rows:
        raise BadInputFile(f"{path}: holds no samples; give a header t,x,y,z and at least one row.")
    commas, samples = has_decimal_commas(rows), list[list[float]]()
    for row in rows:
        samples.append(_sample(f"{path}, line {row.number}", table.separator, header, row.cells, commas))
        if len(samples) > 1 and samples[-1][0] <= samples[-2][0]:
            before, now = samples[-2][0], samples[-1][0]
            raise BadInputFile(
                f"{path}, line {row.number}: t = {now:.15g} does not come after {before:.15g}; times must increase."
            )
    found = np.array(samples)
    _check_units(path, found, rows)
    quaternions = None
    if header == POSE_HEADER:
        quaternions = found[:, 4:] / np.linalg.norm(found[:, 4:], axis=1, keepdims=True)
    return Recording(found[:, 0], found[:, 1:4], quaternions)


_COLUMN: Final = re.compile(
    r"(?P<name>[a-z]+)\s*(?:\[(?P<a>.*)\]|\((?P<b>.*)\)|/\s*(?P<c>\S+)|[_ ](?:in )?(?P<d>\S+))?"
)
"""Name of a column, alone or with its unit: t, t [s], t(s), t/s, t_s."""

_SAME_NAME: Final = {"time": "t", "timestamp": "t"}
_UNITS: Final = {"t": ("s", "sec", "second", "seconds"), "x": ("m", "meter", "meters", "metre", "metres")}
_FACTORS: Final = {
    "ms": "1000",
    "us": "1000000",
    "µs": "1000000",
    "ns": "1000000000",
    "cm": "100",
    "mm": "1000",
}


def _header(path: str, table: TextTable) -> tuple[tuple[str, ...], tuple[TextRow, ...]]:
    """Column names, and the rows below. numpy writes the header as a comment."""
    if not table.rows:
        return (), ()
    first, *rows = table.rows
    if table.comment is not None and all(_is_number(cell) for cell in first.cells):
        number, text = table.comment
        with contextlib.suppress(csv.Error):
            header = _column_names(path, number, cells_of(text, separator_of(text)))
            if header in (POSITION_HEADER, POSE_HEADER):
                return header, table.rows
    header = _column_names(path, first.number, first.cells)
    if header not in (POSITION_HEADER, POSE_HEADER):
        shown = ",".join(first.cells)
        shown = shown if len(shown) <= 60 else shown[:60] + "…"
        raise BadInputFile(
            f"{path}, line {first.number}: the header must be t,x,y,z or t,x,y,z,qw,qx,qy,qz, in this order, not {shown!r}."
        )
    return header, tuple(rows)


def _column_names(path: str, number: int, cells: tuple[str, ...]) -> tuple[str, ...]:
    joined: list[str] = []
    for cell in cells:
        if joined and cell[:1] in ("[", "("):
            # Blanks are separators, and one precedes the unit.
            joined[-1] += cell
        else:
            joined.append(cell.strip().lower())
    while joined and not joined[-1]:
        joined.pop()
    names: list[str] = []
    for cell in joined:
        found = _COLUMN.fullmatch(cell)
        name = "" if found is None else _SAME_NAME.get(found["name"], found["name"])
        if found is None or name not in POSE_HEADER:
            names.append(cell)
            continue
        names.append(name)
        unit = next((part.strip() for part in found.groups()[1:] if part is not None), "")
        allowed = ("1", "-") if name.startswith("q") else _UNITS["t" if name == "t" else "x"]
        if unit and unit not in allowed:
            needed = {"t": "seconds", **dict.fromkeys("xyz", "metres")}.get(name, "numbers without a unit")
            factor = f": divide by {_FACTORS[unit]}" if unit in _FACTORS else ""
            raise BadInputFile(
                f"{path}, line {number}: the header says that {name} is in {unit[:20]!r}; give {needed}{factor}."
            )
    return tuple(names)


def _is_number(cell: str) -> bool:
    try:
        float(cell.replace(",", "."))
    except ValueError:
        return False
    return True


def _sample(
    where: str, separator: str, header: tuple[str, ...], cells: tuple[str, ...], commas: bool
) -> list[float]:
    count = len(header)
    if any(cells[count:]) or len(cells) < count:
        hint = (
            "; where commas are decimal signs, separate the values by semicolons"
            if separator == "," and cells[count:]
            else ""
        )
        raise BadInputFile(f"{where}: has {len(cells)} values, but the header names {count}{hint}.")
    row: list[float] = []
    for name, cell in zip(header, cells, strict=False):
        value = number_in_cell(cell, commas, where, name)
        if not math.isfinite(value):
            raise BadInputFile(f"{where}: {name} = {cell[:40]} is not finite.")
        row.append(value)
    if count > 4 and math.hypot(*row[4:]) < 1e-6:
        raise BadInputFile(f"{where}: qw, qx, qy, qz are all zero, which is not an orientation.")
    return row


def _check_units(path: str, samples: Array, rows: tuple[TextRow, ...]) -> None:
    beyond = np.argwhere(np.abs(samples[:, 1:4]) > REACH)
    if not len(beyond):
        return
    i, axis = beyond[0].tolist()
    largest = float(np.abs(samples[:, 1:4]).max())
    likely = next(((unit, factor) for unit, factor, most in LENGTHS if largest <= most), None)
    guess = f"; these look like {likely[0]}: divide x, y and z by {likely[1]}" if likely else ""
    raise BadInputFile(
        f"{path}, line {rows[i].number}: {'xyz'[axis]} = {samples[i, 1 + axis]:g} m is out of any reach; positions are in metres{guess}."
    )


CSV_SCALARS: Final = ("t", "d", "lambda", "e2", "u", "w", "law_d", "w_law", "lever", "pair")
CSV_SECOND: Final = ("e2_b", "u_b", "w_b", "w_law_b", "lever_b")


def pair_label(names: tuple[str, str]) -> str:
    return f"{names[0]} / {names[1]}"


def write_table(out: TextIO, simulation: Simulation, table: Array, settings: Mapping[str, Any]) -> None:
    """Write a history table (rows ≥ 1, columns) as CSV below # lines with settings and units; the same bytes
    for the same input.
    """
    for key, value in settings.items():
        out.write(f"# {key} = {value}\n")
    history, columns, desired = simulation.history, simulation.room.columns, simulation.history.desired(table)
    # The arms that keep clear may have changed.
    second = () if np.isnan(table[:, COLUMN["authority_b"]]).all() else CSV_SECOND
    followed = np.flatnonzero(~np.isnan(desired[-1]))
    joints = [name.format(kind) for kind in ("q", "dq") for name in columns]
    settings_of = simulation.settings
    header = (*CSV_SCALARS, *second, *joints, *(columns[i].format("qd") for i in followed))
    units = {
        name: unit_of(name, settings_of.experiment.error_unit, settings_of.quantity.unit) for name in header
    } | {"pair": "names"}
    out.write(f"# units = {', '.join(f'{name} [{unit or 1}]' for name, unit in units.items())}\n")
    out.write(",".join(header) + "\n")
    pairs = [pair_label(names) for names in simulation.detector.pair_names]
    heads, more = (table[:, [COLUMN[name] for name in names]] for names in (CSV_SCALARS[:-1], second))
    tails = np.concatenate(
        [more, history.positions(table), history.velocities(table), desired[:, followed]], axis=1
    ).tolist()
    for head, pair, tail in zip(
        heads.tolist(), table[:, COLUMN["pair"]].astype(int).tolist(), tails, strict=True
    ):
        name = pairs[pair] if pair >= 0 else "none"
        out.write(",".join((*map(repr, head), name, *map(repr, tail))) + "\n")
