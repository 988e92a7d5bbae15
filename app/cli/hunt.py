"""`lwr-duet hunt`: a search for runs that break what every run must keep."""

from __future__ import annotations

import os
import shlex
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from app.cli.sweep import cores, progress
from app.runtime.terminal import INTERRUPTED, ending_at_once
from controllers.errors import BadSetting
from scenes.files import written
from scenes.settings import RunSettings, values

if TYPE_CHECKING:
    from scenes.random_runs import RandomRun, RunVerdict


@dataclass(frozen=True)
class Hunt:
    """Make random runs and look for a number that is none, a stop or a top speed that is passed, d_law > d, or a promise d_law ≥ d_m
    that is broken with every condition met by more than a time step explains. Exit code 1 if there is one."""

    runs: int = 1500
    """How many."""
    seed: int = 1
    """Of the settings and start postures: the same seed draws the same runs."""
    seconds: float = 6.0
    """Simulated time of each run [s]."""
    out: Path = Path(".")
    """Folder for the start postures of broken runs."""
    workers: int = 0
    """Processes; 0 takes one a core. The verdicts do not depend on it."""


def hunt(command: Hunt) -> int:
    """Make the runs, print the broken ones with the command that repeats each, and a summary; return the exit code.

    Raises:
        BadSetting: an option is not possible.
    """
    with ending_at_once():
        from scenes.children import computed
        from scenes.random_runs import EXCESS, random_run, run_verdict
    if command.runs < 1 or command.seed < 0 or command.workers < 0:
        raise BadSetting("hunt needs at least 1 run, a seed from 0, and workers from 1, or 0 for one a core.")
    if not 0.0 < command.seconds <= 600.0:
        raise BadSetting(f"seconds = {command.seconds:g} is out of range; give a number above 0 and up to 600.")
    if not os.path.isdir(command.out):
        raise BadSetting(f"out = {command.out}: there is no such folder; make it first.")
    calls = [(command.seed, index, command.seconds) for index in range(command.runs)]
    done = computed(run_verdict, calls, command.workers or cores())
    verdicts: list[RunVerdict] = []
    interrupted = False
    try:
        for _, found in progress(command.runs, "run", iterable=done):
            verdicts.append(found)
    except KeyboardInterrupt:
        interrupted = True
    broken = sorted((found for found in verdicts if found.faults), key=lambda found: found.index)
    for found in broken:
        print(f"run {found.index}: {'; '.join(found.faults)}")
        print(f"  {_repeating(command, found.index, random_run(command.seed, found.index))}")
    promised = [found for found in verdicts if found.promised]
    fallen = [found.excesses for found in promised if len(found.excesses) > 1]
    print(f"{len(verdicts)} runs, {len(broken)} broken. The law promises d ≥ d_law ≥ d_m in {len(promised)}.")
    print(f"d_law is below d_m at some time in {sum(found.margin < 0.0 for found in promised)} of these.")
    print(f"It falls there by more than {1e3 * EXCESS:g} mm with every condition met in {len(fallen)}", end="")
    if fallen:
        at_dt, at_last = (1e3 * max(excesses[i] for excesses in fallen) for i in (0, -1))
        print(f", by {at_dt:.3g} mm at most; by {at_last:.3g} mm at the smallest of its time steps, an eighth or less", end="")
    print(".")
    if interrupted:
        print("Interrupted; the runs that were not made are not counted.", file=sys.stderr)
        return INTERRUPTED
    return 1 if broken else 0


def _repeating(command: Hunt, index: int, random: RandomRun) -> str:
    """Return the command line that makes a run again, and write its start posture, if it has one of its own, into the folder."""
    words = ["lwr-duet", "run", "--seconds", f"{command.seconds:g}"]
    usual = values(RunSettings())
    given = values(random.settings)
    if random.start is not None:
        path = command.out / f"hunt-{command.seed}-{index}.txt"
        with written(path, "out") as new:
            new.write_text(" ".join(map(repr, random.start.tolist())) + "\n", encoding="utf-8")
        given["start"] = path
    for key, value in given.items():
        option = f"--{key.replace('_', '-')}"
        if isinstance(value, bool):
            words += [option] * value
        elif value != usual[key]:
            words += [option, str(value)]
    return shlex.join(words)
