"""The figures of `lwr-duet bench`, row by row, and as ratios to those of an earlier run on the same machine, which mean more than times."""

import json
import platform
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np

from app.bench.processes import limit_of
from app.bench.step import measure_run, measure_steps, measure_what_if
from app.bench.visitors import FULL_PAGE, measure_crowd, measure_sessions, measure_visitor
from app.version import duet_version
from controllers.errors import BadInputFile
from scenes.files import input_content

BenchFigures = dict[str, dict[str, float]]
"""What was measured → figure → value."""

BenchRows = Iterator[tuple[str, dict[str, float]]]
"""The same, one after the other."""

MOST_BYTES: Final = 10_000_000
"""Largest file of figures."""

WATCHERS: Final = 30
SESSIONS: Final = 8


def measured_figures(steps: int, seconds: float, robot: str) -> BenchRows:
    """Yield all figures.

    Args:
        steps: measured steps of each scene.
        seconds: duration of each measurement of visitors [s].
        robot: the arms of the measured steps.
    """
    yield from measure_steps(steps, robot).items()
    yield "run of 46 s", measure_run()
    yield "what if, 30 s again", measure_what_if()
    yield "one visitor", measure_visitor(seconds)
    yield "one visitor, ghost and four plots", measure_visitor(seconds, FULL_PAGE)
    yield f"lecture with {WATCHERS} watchers", measure_crowd(WATCHERS, seconds, lecture=True)
    yield f"{SESSIONS} private sessions", measure_crowd(SESSIONS, seconds, lecture=False)


def measure_capacity(sessions: Iterable[int], seconds: float) -> BenchRows:
    """Yield what so many private sessions cost, one number after the other.

    Args:
        seconds: duration of each [s].
    """
    for count in sessions:
        yield f"{count} private sessions", measure_sessions(count, seconds)


def printed(rows: BenchRows) -> dict[str, Any]:
    """Print every row as soon as it is measured, then what takes the server's time where that was measured.

    Returns:
        The figures, ready for JSON.
    """
    figures: BenchFigures = {}
    for name, row in rows:
        figures[name] = row
        print(_row(name, row, lambda value: f"{value:.3g}" if abs(value) < 10 else f"{value:.1f}"), flush=True)
    for name, row in figures.items():
        if limit := limit_of(row):
            print(f"{name:36s} {limit}")
    machine = f"{platform.machine()}, Python {platform.python_version()}, numpy {np.__version__}"
    return {"version": duet_version(), "machine": machine, "figures": figures}


def read_figures(path: Path) -> dict[str, Any]:
    """Return figures saved earlier.

    Raises:
        BadInputFile: the file cannot be read, or does not hold figures.
    """
    try:
        result = json.loads(input_content(path, MOST_BYTES))
        if not isinstance(result["figures"], dict):
            raise TypeError
    except (ValueError, KeyError, TypeError, RecursionError):
        raise BadInputFile(f"{path}: is not a file that `bench --out` has written.") from None
    return result


def ratio_table(now: dict[str, Any], before: dict[str, Any]) -> str:
    """Return a table of the ratios new : old of every figure that both have."""
    ratios: BenchFigures = {}
    for name, figures in now["figures"].items():
        old = before["figures"].get(name, {})
        ratios[name] = {key: value / old[key] for key, value in figures.items() if old.get(key)}
    rows = [_row(name, figures, lambda value: f"{value:.2f}x") for name, figures in ratios.items()]
    return "\n".join((f"\nratio to version {before.get('version', '?')}", *rows))


def _row(name: str, figures: dict[str, float], shown: Callable[[float], str]) -> str:
    return f"{name:36s} " + "   ".join(f"{key} {shown(value)}" for key, value in figures.items())
