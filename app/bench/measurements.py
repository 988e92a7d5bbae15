"""All figures of `lwr-duet bench`, as a table, and as ratios to those of an earlier run on the same machine, which mean more than times."""

import json
import platform
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, Final

import numpy as np

from app.bench.disturbances import DISTURBANCES
from app.bench.fairness import measure_neighbour
from app.bench.server_times import limit_of
from app.bench.step import measure_run, measure_steps, measure_what_if
from app.bench.visitors import FULL_PAGE, measure_crowd, measure_sessions, measure_visitor
from app.version import duet_version
from controllers.errors import BadInputFile
from scenes.files import read_file

BenchFigures = dict[str, dict[str, float]]
"""What was measured → figure → value."""

MOST_BYTES: Final = 10_000_000
"""Largest file of figures."""

WATCHERS: Final = 30
SESSIONS: Final = 8


def measure(steps: int, seconds: float, robot: str = "lwr") -> dict[str, Any]:
    """Return all figures, ready for JSON.

    Args:
        steps: measured steps of each scene.
        seconds: duration of each measurement of visitors [s].
        robot: the arms of the measured steps.
    """
    return _described(
        {
            **measure_steps(steps, robot),
            "run of 46 s": measure_run(),
            "what if, 30 s again": measure_what_if(),
            "one visitor": measure_visitor(seconds),
            "one visitor, ghost and four plots": measure_visitor(seconds, FULL_PAGE),
            f"lecture with {WATCHERS} watchers": measure_crowd(WATCHERS, seconds, lecture=True),
            f"{SESSIONS} private sessions": measure_crowd(SESSIONS, seconds, lecture=False),
        }
    )


def measure_capacity(sessions: Iterable[int], seconds: float) -> dict[str, Any]:
    """Return what so many private sessions cost, one number after the other, ready for JSON.

    Args:
        seconds: duration of each [s].
    """
    return _described({f"{count} private sessions": measure_sessions(count, seconds) for count in sessions})


def measure_fairness(seconds: float, names: Iterable[str] = tuple(DISTURBANCES)) -> dict[str, Any]:
    """Return what a neighbour sees during each of `app.bench.disturbances.DISTURBANCES`, ready for JSON.

    Args:
        seconds: duration of each [s].
    """
    return _described({name: measure_neighbour(name, seconds) for name in names})


def _described(figures: BenchFigures) -> dict[str, Any]:
    machine = f"{platform.machine()}, Python {platform.python_version()}, numpy {np.__version__}"
    return {"version": duet_version(), "machine": machine, "figures": figures}


def table_text(result: dict[str, Any]) -> str:
    """Return the figures as a table, followed by what takes the server's time where that was measured."""
    table = _table(result["figures"], lambda value: f"{value:.3g}" if abs(value) < 10 else f"{value:.1f}")
    limits = {name: limit_of(figures) for name, figures in result["figures"].items()}
    return "\n".join((table, *(f"{name:36s} {limit}" for name, limit in limits.items() if limit)))


def read_figures(path: Path) -> dict[str, Any]:
    """Return figures saved earlier.

    Raises:
        BadInputFile: the file cannot be read, or does not hold figures.
    """
    try:
        result = json.loads(read_file(path, MOST_BYTES))
        if not isinstance(result["figures"], dict):
            raise TypeError
    except OSError as error:
        raise BadInputFile(f"{path}: cannot be read ({error.strerror}).") from None
    except (ValueError, KeyError, TypeError, RecursionError):
        raise BadInputFile(f"{path}: is not a file that `bench --out` has written.") from None
    return result


def compare(now: dict[str, Any], before: dict[str, Any]) -> str:
    """Return a table of the ratios new : old of every figure that both have."""
    ratios: BenchFigures = {}
    for name, figures in now["figures"].items():
        old = before["figures"].get(name, {})
        ratios[name] = {key: value / old[key] for key, value in figures.items() if old.get(key)}
    return f"\nratio to version {before.get('version', '?')}\n" + _table(ratios, lambda value: f"{value:.2f}x")


def _table(figures: BenchFigures, shown: Callable[[float], str]) -> str:
    rows = {name: "   ".join(f"{key} {shown(value)}" for key, value in row.items()) for name, row in figures.items()}
    return "\n".join(f"{name:36s} {cells}" for name, cells in rows.items())
