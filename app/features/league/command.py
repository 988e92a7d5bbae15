"""`lwr-duet league`."""

from __future__ import annotations

import os
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import tyro

from app.features.marks.command import ISOLATION, handed_in
from app.features.sweep.computing import computing
from app.runtime.progress import progress
from app.runtime.terminal import INTERRUPTED, ending_at_once
from controllers.errors import BadSetting
from scenes.files import written


@dataclass(frozen=True)
class League:
    """Play all laws in the same runs, and write tables and a page.

    Every built-in law and every given one runs with its own settings, and with those at which all keep the same
    distance on average. Give the same command to continue, and further files to add them."""

    laws: tyro.conf.Positional[tuple[Path, ...]] = ()
    """Files with laws (*.py), or folders of them. Nothing in them is trusted; see `grade`."""
    out: Path = Path("league")
    """Folder for the tables and the page."""
    seed_word: str = ""
    """Also play persons that follow from this word, who are in no file: no law is fitted to them."""
    quick: bool = False
    """Two persons instead of eight, for a first look."""
    workers: int = 0
    """Processes; 0 takes one a core. The figures do not depend on it."""
    scheduler: str | None = None
    """Address of a Dask scheduler, such as tcp://host:8786, see `sweep`."""
    seconds: float = 600.0
    """Longest time for a file's runs in one scene [s]."""


def league(command: League) -> int:
    """Returns the exit code.

    Raises:
        BadSetting, BadInputFile: before anything runs.
        DuetError: workers were ended from outside; outcomes so far are kept.
    """
    with ending_at_once():
        from app.features.league.entrants import entrants, played
        from app.features.league.league_files import PART, LeagueFiles
        from app.features.league.league_page import league_page, league_tables, markdown
        from app.features.league.league_runs import FULL, QUICK
        from app.features.marks.fence import FenceLimits, isolation_of
        from app.features.sweep.dask_cluster import environment

    if not 1.0 <= command.seconds <= 86_400.0:
        raise BadSetting(f"seconds = {command.seconds:g} is out of range; give 1 to 86400.")
    everyone = entrants(_files(command.laws))
    place = computing(command.workers, command.scheduler)
    schedule = replace(QUICK if command.quick else FULL, word=command.seed_word.strip())
    files = LeagueFiles(command.out, schedule, everyone)
    try:
        missing = files.missing(command.seconds)
        if missing:
            limits = FenceLimits(seconds=command.seconds)
            calls = [(entrant, schedule, event, limits) for entrant, event in missing]
            with place as compute, files.recording() as add, progress(len(missing), "scene") as bar:
                if any(entrant.text is not None for entrant, _ in missing):
                    # Where the runs are played, perhaps on another computer.
                    for _, level in compute(isolation_of, [(limits,)]):
                        if level in ISOLATION:
                            print(f"lwr-duet: {ISOLATION[level]}", file=sys.stderr)
                for index, outcome in compute(played, calls):
                    add(*missing[index], outcome)
                    bar.update()
        for path in files.finish():
            print(path)
        tables = league_tables(everyone, files.outcomes, schedule)
        texts = {
            "league.md": markdown(tables),
            "league.html": league_page(everyone, files.outcomes, tables, schedule, environment()),
        }
        for name, text in texts.items():
            with written(command.out / name, "out") as new:
                new.write_text(text, encoding="utf-8", newline="\n")
            print(command.out / name)
    except KeyboardInterrupt:
        left = len(files.missing(command.seconds))
        print(
            f"{left} scenes are left, the rest is in {command.out / PART}; the same command continues from there.",
            file=sys.stderr,
        )
        return INTERRUPTED
    return 0


def _files(given: tuple[Path, ...]) -> list[Path]:
    """Raises `BadSetting` if a folder holds no law."""
    found: list[Path] = []
    for path in given:
        inside = (
            [file for file in handed_in(path) if file.suffix.lower() == ".py"]
            if os.path.isdir(path)
            else [path]
        )
        if not inside:
            raise BadSetting(f"{path}: holds no law (*.py).")
        found += inside
    return found
