"""Inputs and outcomes as CSV: where a person's hand wants to be, and what the arms then did."""

import csv
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final, TextIO

import numpy as np
import pinocchio as pin

from controllers.errors import BadInputFile
from controllers.kinematics import Array
from scenes.files import input_content
from scenes.history import COLUMN, unit_of
from scenes.simulation import Simulation
from scenes.targets import HandTarget, between

POSITION_HEADER: Final = ("t", "x", "y", "z")
POSE_HEADER: Final = (*POSITION_HEADER, "qw", "qx", "qy", "qz")
REACH: Final = 10.0
"""Largest believable coordinate of a hand [m]; more is a file in millimetres."""
MOST_BYTES: Final = 64_000_000
"""Largest CSV file of inputs."""


class Recording:
    """A hand's wanted path through samples: straight between two of them, at rest after the last.

    Args:
        times: (k,) [s], strictly increasing.
        positions: (k, 3) world [m].
        quaternions: (k, 4) as w, x, y, z of unit length, or None if only the place matters.
    """

    def __init__(self, times: Array, positions: Array, quaternions: Array | None = None) -> None:
        self.times, self.positions = times, positions
        self._rotations = None if quaternions is None else [pin.Quaternion(w, x, y, z) for w, x, y, z in quaternions]

    def target(self, time: float) -> HandTarget:
        """Return where the hand should be at a time [s]."""
        i, j, part = between(self.times, time)
        position = self.positions[i] + (self.positions[j] - self.positions[i]) * part
        if self._rotations is None:
            return HandTarget(position)
        return HandTarget(position, self._rotations[i].slerp(part, self._rotations[j]).toRotationMatrix())


def read_inputs(path: Path) -> Recording:
    """Return the recording in a CSV file with the header `t,x,y,z` or `t,x,y,z,qw,qx,qy,qz`; lines that start with # are skipped.

    Raises:
        BadInputFile: no such file, or not such a file; names the line.
    """
    return inputs_from(input_content(path, MOST_BYTES), str(path))


def inputs_from(data: bytes, path: str) -> Recording:
    """Return the recording in a CSV file's content; see `read_inputs`. `path`: of the file, for messages."""
    try:
        lines = data.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError:
        raise BadInputFile(f"{path}: is not a text file; give a CSV file with the header t,x,y,z.") from None
    rows: list[list[float]] = []
    header: tuple[str, ...] = ()
    for number, line in enumerate(lines, 1):
        if not line.strip() or line.startswith("#"):
            continue
        try:
            cells = next(csv.reader([line]))
        except csv.Error as error:
            raise BadInputFile(f"{path}, line {number}: cannot be read as CSV ({error}).") from None
        if not header:
            header = tuple(cell.strip().lower() for cell in cells)
            if header not in (POSITION_HEADER, POSE_HEADER):
                raise BadInputFile(f"{path}, line {number}: the header must be t,x,y,z or t,x,y,z,qw,qx,qy,qz.")
            continue
        rows.append(_checked_row(path, number, header, cells, rows[-1][0] if rows else -math.inf))
    if not rows:
        raise BadInputFile(f"{path}: holds no samples; give a header t,x,y,z and at least one row.")
    table = np.array(rows)
    quaternions = None
    if header == POSE_HEADER:
        quaternions = table[:, 4:] / np.linalg.norm(table[:, 4:], axis=1, keepdims=True)
    return Recording(table[:, 0], table[:, 1:4], quaternions)


def _checked_row(path: str, number: int, header: tuple[str, ...], cells: list[str], before: float) -> list[float]:
    where = f"{path}, line {number}"
    if len(cells) != len(header):
        raise BadInputFile(f"{where}: has {len(cells)} values, but the header names {len(header)}.")
    row: list[float] = []
    for name, cell in zip(header, cells, strict=True):
        try:
            value = float(cell)
        except ValueError:
            raise BadInputFile(f"{where}: {name} = {cell.strip()[:40]!r} is not a number.") from None
        if not math.isfinite(value):
            raise BadInputFile(f"{where}: {name} = {cell.strip()[:40]} is not finite.")
        if name in ("x", "y", "z") and abs(value) > REACH:
            raise BadInputFile(f"{where}: {name} = {value:g} m is out of any reach; positions are in metres.")
        row.append(value)
    if row[0] <= before:
        raise BadInputFile(f"{where}: t = {row[0]:g} does not come after {before:g}; times must increase.")
    if len(row) > 4 and math.hypot(*row[4:]) < 1e-6:
        raise BadInputFile(f"{where}: qw, qx, qy, qz are all zero, which is no orientation.")
    return row


CSV_SCALARS: Final = ("t", "d", "lambda", "e2", "u", "w", "law_d", "w_law", "lever", "pair")
CSV_SECOND: Final = ("e2_b", "u_b", "w_b", "w_law_b", "lever_b")
"""Further columns where two arms keep clear: the second one's."""


def pair_label(names: tuple[str, str]) -> str:
    """Return the readable name of a pair of bodies."""
    return f"{names[0]} / {names[1]}"


def write_table(out: TextIO, simulation: Simulation, table: Array, settings: Mapping[str, Any]) -> None:
    """Write a history table (rows ≥ 1, columns) as CSV, on top of it # lines with the settings, and with the unit of every column.

    The same table and settings give the same bytes.

    Args:
        simulation: that made the history.
        settings: key → value, in order.
    """
    for key, value in settings.items():
        out.write(f"# {key} = {value}\n")
    history, columns, desired = simulation.history, simulation.room.columns, simulation.history.desired(table)
    # Who keeps clear may have changed.
    second = () if np.isnan(table[:, COLUMN["authority_b"]]).all() else CSV_SECOND
    followed = np.flatnonzero(~np.isnan(desired[-1]))
    joints = [name.format(kind) for kind in ("q", "dq") for name in columns]
    header = (*CSV_SCALARS, *second, *joints, *(columns[i].format("qd") for i in followed))
    units = {name: unit_of(name, simulation.settings.experiment.error_unit) for name in header} | {"pair": "names"}
    out.write(f"# units = {', '.join(f'{name} [{unit or 1}]' for name, unit in units.items())}\n")
    out.write(",".join(header) + "\n")
    pairs = [pair_label(names) for names in simulation.detector.pair_names]
    heads, more = (table[:, [COLUMN[name] for name in names]] for names in (CSV_SCALARS[:-1], second))
    tails = np.concatenate([more, history.positions(table), history.velocities(table), desired[:, followed]], axis=1).tolist()
    for head, pair, tail in zip(heads.tolist(), table[:, COLUMN["pair"]].astype(int).tolist(), tails, strict=True):
        name = pairs[pair] if pair >= 0 else "none"
        out.write(",".join((*map(repr, head), name, *map(repr, tail))) + "\n")
