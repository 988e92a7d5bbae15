"""`lwr-duet sweep`."""

from __future__ import annotations

import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Literal

import tyro

from app.cli.options import Flat, RunOptions, settings_of_options
from app.features.sweep.computing import computing
from app.runtime.progress import progress
from app.runtime.terminal import INTERRUPTED, ending_at_once
from controllers.errors import BadSetting
from scenes.settings import RunSettings, values


@dataclass(frozen=True)
class Sweep:
    """Run a grid of settings, and write one table and its maps.

    Runs one scene on all cores or a cluster's. Give the same command to continue."""

    over: Annotated[tuple[str, ...], tyro.conf.UseAppendAction, tyro.conf.arg(metavar="KEY=VALUES")] = ()
    """A setting and its values: n=1:20 (steps of 1), v=0.05:0.6:12 (12 values) or law=smooth_priority,unprotected. May be repeated."""
    seconds: float = 46.0
    """Simulated time of each run [s]."""
    out: Path = Path("sweep")
    """Folder for the table and the maps."""
    format: Literal["csv", "parquet"] = "csv"
    """Format of the table; parquet needs pyarrow."""
    workers: int = 0
    """Processes; 0 takes one a core. The figures do not depend on it."""
    scheduler: str | None = None
    """Address of a Dask scheduler, such as tcp://host:8786: its workers run the grid in place of this computer (needs the extra
    `cluster`)."""
    maps: bool = True
    """Draw d_min, e2_max and ddq_max."""
    settings: Flat[RunOptions] = field(default_factory=RunOptions)  # type: ignore[valid-type]
    """All that is not swept."""


def sweep(command: Sweep) -> int:
    """Returns the exit code.

    Raises:
        BadSetting, BadInputFile: before anything runs.
        DuetError: workers were ended from outside; rows so far are kept.
    """
    with ending_at_once():
        from app.features.sweep.heatmaps import draw_maps
        from app.features.sweep.sweep_files import SweepFiles
        from scenes.sweep import read_grid, run_points

    settings: RunSettings = settings_of_options(command.settings, RunSettings())
    place = computing(command.workers, command.scheduler)
    grid = read_grid(settings, command.over, command.seconds)
    given = {key for key, value in values(settings).items() if value != values(RunSettings())[key]}
    if both := given & {axis.key for axis in grid.axes}:
        raise BadSetting(
            f"{', '.join(sorted(both))} is swept, and also has one value; leave out --over or the value."
        )
    files = SweepFiles(command.out, grid, command.format)
    try:
        missing = files.missing()
        if missing:
            kept = grid.size - len(missing)
            with place as compute, files.recording() as add, progress(grid.size, "run", initial=kept) as bar:
                for index, figures in run_points(grid, missing, compute):
                    add(index, figures)
                    bar.update()
        files.finish()
    except KeyboardInterrupt:
        print(
            f"{len(files.rows)} of {grid.size} runs are in {files.part}; the same command continues from there.",
            file=sys.stderr,
        )
        return INTERRUPTED
    print(files.table)
    if command.maps:
        drawn = draw_maps(grid, files.rows, command.out)
        for path in drawn:
            print(path)
        if not drawn:
            print(
                "No maps: too many values for panels side by side; sweep fewer settings at once.",
                file=sys.stderr,
            )
    return 0
