"""Further start postures: built in, or from a file."""

import math
from pathlib import Path
from typing import Final

import numpy as np

from controllers.errors import BadInputFile
from controllers.kinematics import Array
from scenes.csv_reading import TextRow, has_decimal_commas, number_in_cell, read_text_table
from scenes.files import input_content
from scenes.room import Room
from scenes.settings import RunSettings

BETWEEN: Final = np.array(
    [0.90, 1.48, -1.67, -1.26, 0.07, -1.01, -0.22, -0.70, 1.11, 1.18, -1.88, 0.65, -0.42, -0.35],
)
"""Posture of two LWRs on the torso (14,) [rad] for a tie of two pairs.

If the guided arm avoids and the autopilot of seed 396 moves it at v = 0.05 m/s, it slides along the tie and,
with the closest pair, loses 121 mm of 150 mm against an obstacle at rest, with full authority. Found by
random search.
"""


def start_of(settings: RunSettings, room: Room) -> Array:
    """Start q (nv,) [rad, m]: the room's, or a fitting one of the settings."""
    return BETWEEN if settings.start == "between" and settings.fits_between else room.start


MOST_BYTES: Final = 100_000


def read_start(path: Path, room: Room) -> Array:
    """q (nv,) [rad, m] of a file in any form of `scenes.csv_reading`.

    One line or column of numbers, or a row below a header with the columns of q.

    Raises:
        BadInputFile: no such file, not such a file, or outside the joints' limits.
    """
    table = read_text_table(input_content(path, MOST_BYTES), str(path), "give joint angles in radians")
    names = [column.format("q") for column in room.columns]
    lines = [_without_empty_end(row.cells) for row in table.rows]
    if table.separator == "," and len(lines) == len(names) > 1 and all(len(line) <= 2 for line in lines):
        # One column in which the comma is the decimal sign: nothing else has this number of lines.
        lines = [[",".join(line)] for line in lines]
    if lines and set(lines[0]) & set(names):
        lines = [_named(path, names, lines)]
    elif len(lines) > 1 and any(len(line) != 1 for line in lines):
        raise BadInputFile(
            f"{path}: has {len(lines)} lines of numbers; give one line or one column, {len(names)} numbers."
        )
    cells = tuple(cell for line in lines for cell in line)
    if len(cells) != len(names):
        raise BadInputFile(
            f"{path}: has {len(cells)} numbers, but {len(names)} joints move: {', '.join(names)}."
        )
    commas = has_decimal_commas((TextRow(1, cells),))
    return np.array(
        [
            _position(path, room, joint, name, cell, commas)
            for joint, (name, cell) in enumerate(zip(names, cells, strict=True))
        ]
    )


def _without_empty_end(cells: tuple[str, ...]) -> list[str]:
    kept = list(cells)
    while kept and not kept[-1]:
        kept.pop()
    return kept


def _named(path: Path, names: list[str], lines: list[list[str]]) -> list[str]:
    header, *rows = lines
    if missing := [name for name in names if name not in header]:
        raise BadInputFile(
            f"{path}: the header has no column {', '.join(missing)}; it needs {', '.join(names)}."
        )
    if len(rows) != 1 or len(rows[0]) != len(header):
        raise BadInputFile(f"{path}: give one row of {len(header)} values below the header.")
    return [rows[0][header.index(name)] for name in names]


def _position(path: Path, room: Room, joint: int, name: str, cell: str, commas: bool) -> float:
    value = number_in_cell(cell, commas, str(path), name)
    if not math.isfinite(value):
        raise BadInputFile(f"{path}: {name} = {cell[:40]} is not finite.")
    low, high = float(room.model.lowerPositionLimit[joint]), float(room.model.upperPositionLimit[joint])
    if not low <= value <= high:
        unit = "m" if name.startswith("ball_") else "rad"
        raise BadInputFile(
            f"{path}: {name} = {value:g} is outside its limits; give {low:.4f} to {high:.4f} {unit}."
        )
    return value
