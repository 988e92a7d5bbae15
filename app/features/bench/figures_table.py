"""Tables of figures, and of ratios to an earlier run on the same machine."""

import json
import platform
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np

from app.version import duet_version
from controllers.errors import BadInputFile
from scenes.files import input_content, written

BenchFigures = dict[str, dict[str, float]]
"""Measured thing → figure → value."""

BenchRows = Iterator[tuple[str, dict[str, float]]]

MOST_BYTES: Final = 10_000_000


def printed(rows: BenchRows) -> dict[str, Any]:
    """Print each row when measured; return the figures for JSON."""
    figures: BenchFigures = {}
    for name, row in rows:
        figures[name] = row
        print(
            _row(name, row, lambda value: f"{value:.3g}" if abs(value) < 10 else f"{value:.1f}"), flush=True
        )
    machine = f"{platform.machine()}, Python {platform.python_version()}, numpy {np.__version__}"
    return {"version": duet_version(), "machine": machine, "figures": figures}


def read_figures(path: Path) -> dict[str, Any]:
    """Raises `BadInputFile` without readable figures."""
    try:
        result = json.loads(input_content(path, MOST_BYTES))
        if not isinstance(result["figures"], dict):
            raise TypeError
    except (ValueError, KeyError, TypeError, RecursionError):
        raise BadInputFile(f"{path}: is not a file that `--out` of a benchmark has written.") from None
    return result


def ratio_table(now: dict[str, Any], before: dict[str, Any]) -> str:
    """Ratios new : old of common figures."""
    ratios: BenchFigures = {}
    for name, figures in now["figures"].items():
        old = before["figures"].get(name, {})
        ratios[name] = {key: value / old[key] for key, value in figures.items() if old.get(key)}
    rows = [_row(name, figures, lambda value: f"{value:.2f}x") for name, figures in ratios.items()]
    return "\n".join((f"\nratio to version {before.get('version', '?')}", *rows))


def save_figures(result: dict[str, Any], out: Path) -> None:
    """Raises `BadSetting` if the file cannot be written."""
    with written(out, "out") as new:
        new.write_text(json.dumps(result, indent=2) + "\n", encoding="utf-8", newline="\n")


def _row(name: str, figures: dict[str, float], shown: Callable[[float], str]) -> str:
    return f"{name:36s} " + "   ".join(f"{key} {shown(value)}" for key, value in figures.items())
