"""CSV of a run: settings, then every step."""

import gzip
import io
from itertools import pairwise
from typing import Any, Final

from app.recording.law_heading import law_heading
from app.recording.run_file import made_here
from scenes.history import COLUMN
from scenes.inputs import Recorded
from scenes.recording import write_table
from scenes.rerun import newest_steps, rerun
from scenes.settings import named_values, values
from scenes.simulation import Simulation
from scenes.wanted import check_wanted

LARGEST: Final = 16_000_000
"""Largest uncompressed table [B]: two minutes at the usual time step."""


def changes(recorded: Recorded) -> tuple[tuple[float, str, Any], ...]:
    """Time [s], key and new value of each change."""
    found: list[tuple[float, str, Any]] = []
    time = recorded.begin
    for before, after in pairwise(recorded.stretches):
        time += before.seconds
        old, new = values(before.settings), values(after.settings)
        found += [(time, key, new[key]) for key in new if new[key] != old[key]]
    return tuple(found)


def csv_bytes(recorded: Recorded, seconds: float) -> bytes:
    """CSV, compressed above `LARGEST`; equal pieces give equal bytes. `seconds`: length [s]; inf for all.

    Raises:
        BadSetting: the run is not possible here.
    """
    table = rerun(recorded).table[-newest_steps(recorded, seconds) :]
    check_wanted()
    first = float(table[0, COLUMN["t"]])
    settings: dict[str, Any] = {"duet": made_here()["duet"], **named_values(recorded.settings)}
    for time, key, value in changes(recorded):
        if recorded.law is not None and key == "law":
            continue
        settings[key if time <= first + 1e-9 else f"from {time:.6g} s on: {key}"] = value
    if recorded.law is not None:
        settings |= law_heading(recorded.law.file, recorded.law.sha256)
    out = io.StringIO()
    write_table(out, Simulation(recorded.settings, 1), table, settings)
    data = out.getvalue().encode()
    return data if len(data) <= LARGEST else gzip.compress(data, 6, mtime=0)


def csv_suffix(data: bytes) -> str:
    return ".csv.gz" if data[:2] == b"\x1f\x8b" else ".csv"
