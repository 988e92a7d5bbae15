"""`lwr-duet hunt` and `falsify`: searches for runs that break what every run must keep, or the promise although its conditions hold."""

from __future__ import annotations

import os
import shlex
import sys
from dataclasses import dataclass, field
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Final

from app.cli.options import Flat, RunOptions, settings_of_options
from app.runtime.progress import cores, progress
from app.runtime.terminal import INTERRUPTED, ending_at_once
from controllers.errors import BadSetting
from scenes.files import check_writable, written
from scenes.settings import RunSettings, specs, values

if TYPE_CHECKING:
    from app.features.studies.counterexample import Found
    from scenes.random_runs import RandomRun, RunVerdict


@dataclass(frozen=True)
class Hunt:
    """Make random runs, and look for one that breaks a bound.

    That is a number that is not finite, a stop or a top speed that is passed, d_law > d, or the promise d_law ≥ d_m
    broken with every condition met, by more than a time step explains. Exit code 1 if a run breaks one."""

    runs: int = 1500
    """How many."""
    seed: int = 1
    """Seed of the settings and start postures: the same seed draws the same runs."""
    seconds: float = 6.0
    """Simulated time of each run [s]."""
    out: Path = Path(".")
    """Folder for the start postures of broken runs."""
    workers: int = 0
    """Processes; 0 takes one a core. The verdicts do not depend on it."""


def hunt(command: Hunt) -> int:
    """Make the runs, print the broken ones with commands that repeat them, and a summary; return the exit
    code.

    Raises:
        BadSetting: an option is not possible.
    """
    with ending_at_once():
        from scenes.children import computed
        from scenes.random_runs import EXCESS, random_run, run_verdict
    if command.runs < 1 or command.seed < 0 or command.workers < 0:
        raise BadSetting("hunt needs at least 1 run, a seed from 0, and workers from 1, or 0 for one a core.")
    if not 0.0 < command.seconds <= 600.0:
        raise BadSetting(
            f"seconds = {command.seconds:g} is out of range; give a number above 0 and up to 600."
        )
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
    print(
        f"It falls there by more than {1e3 * EXCESS:g} mm with every condition met in {len(fallen)}", end=""
    )
    if fallen:
        at_dt, at_last = (1e3 * max(excesses[i] for excesses in fallen) for i in (0, -1))
        print(
            f", by {at_dt:.3g} mm at most; by {at_last:.3g} mm at the smallest of its time steps, an eighth or less",
            end="",
        )
    print(".")
    if interrupted:
        print("Interrupted; the runs that were not made are not counted.", file=sys.stderr)
        return INTERRUPTED
    return 1 if broken else 0


def _repeating(command: Hunt, index: int, random: RandomRun) -> str:
    """Command line that repeats a run; writes its own start posture, if it has one, into the folder."""
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


LONGEST: Final = 86_400.0
"""Longest search [s]."""

FASTEST: Final = 20
"""Most starts that a process searches in a second."""


@dataclass(frozen=True)
class Falsify:
    """Search for the run that breaks the promise d_law ≥ d_m most.

    Varies start postures, and a person's ways and speeds, for the run in which d_law falls farthest below d_m while
    w ≤ v, J_d is regular, no joint is at its limit and the robot is ideal. Exit code 1 if that is more than 0.1 mm,
    at dt and at dt/4."""

    seconds: float = 60.0
    """How long to search [s]."""
    out: Path | None = None
    """Write the worst run to this run file, which the page replays."""
    starts: int = 0
    """How many start postures to search at most; 0 takes as many as there is time for."""
    skip: int = 0
    """How many start postures of the seed to leave out, because an earlier search has been there."""
    workers: int = 0
    """Processes; 0 takes one a core. What is found from a start does not depend on it."""
    settings: Flat[RunOptions] = field(default_factory=RunOptions)  # type: ignore[valid-type]
    """The experiment."""


def falsify(command: Falsify) -> int:
    """Search, print the worst run and the losses with a missing condition, write the run; return the exit
    code.

    Raises:
        BadSetting, BadInputFile: an option is not possible.
    """
    with ending_at_once():
        from app.features.studies.counterexample import BROKEN, check, replayed, searched
        from app.recording.run_file import saved_bytes
        from scenes.children import computed
    settings: RunSettings = settings_of_options(command.settings, RunSettings())
    check(settings)
    if not 0.0 < command.seconds <= LONGEST:
        raise BadSetting(
            f"seconds = {command.seconds:g} is out of range; give a number above 0 and up to {LONGEST:g}."
        )
    if min(command.starts, command.skip, command.workers) < 0:
        raise BadSetting("falsify needs starts and skip from 0, and workers from 1, or 0 for one a core.")
    if command.out is not None:
        if command.out.suffix != ".npz":
            raise BadSetting(f"out = {command.out}: a run file ends in .npz; give a name like worst.npz.")
        check_writable(command.out, "out")
    begin, workers = monotonic(), command.workers or cores()
    most = command.starts or max(1, round(FASTEST * command.seconds)) * workers
    calls = (
        (settings, settings.seed, command.skip + place, begin + command.seconds) for place in range(most)
    )
    found: dict[int, Found] = {}
    interrupted = False
    try:
        with progress(round(command.seconds), "s") as bar:
            for index, one in computed(searched, calls, workers):
                found[index] = one
                elapsed = monotonic() - begin
                bar.set_postfix_str(f"{1000.0 * max(each.loss.lost for each in found.values()):.1f} mm lost")
                bar.update(min(round(elapsed), bar.total) - bar.n)
                if elapsed >= command.seconds:
                    break
    except KeyboardInterrupt:
        interrupted = True
    if found:
        _report(settings, found, monotonic() - begin)
        if command.out is not None:
            with written(command.out, "out") as new:
                new.write_bytes(saved_bytes(replayed(_worst(found).attack)))
            print(command.out)
    if interrupted:
        done = command.skip + next(place for place in range(most + 1) if place not in found)
        print(f"Interrupted; --seed {settings.seed} --skip {done} goes on from here.", file=sys.stderr)
        return INTERRUPTED
    return 1 if _worst(found).loss.lost > BROKEN else 0


def _worst(found: dict[int, Found]) -> Found:
    """Worst run; the earliest start of equal ones."""
    return max((one for _, one in sorted(found.items())), key=lambda one: one.badness)


def _report(settings: RunSettings, found: dict[int, Found], seconds: float) -> None:
    from app.features.studies.counterexample import BLAMED, BROKEN, FINER
    from scenes.promise import Condition

    worst, law = _worst(found), settings.law
    runs, pairs = sum(one.runs for one in found.values()), specs()["pairs"].options()[law.pairs]
    print(f"{len(found)} start postures, {runs} runs in {seconds:.0f} s.")
    print(f"{settings.experiment.label}: {law.entry.label}, {pairs}, v = {law.nominal_velocity:g} m/s.")
    held = ", ".join(condition.value for condition in (*BLAMED, Condition.ROBOT))
    if not law.entry.promises:
        print("This law makes no promise.")
    if worst.loss.lost > BROKEN:
        said = "The promise breaks: d_law" if law.entry.promises else "d_law"
        print(f"{said} falls {1000.0 * worst.loss.lost:.1f} mm below d_m, at dt and at dt/{FINER}.")
        strict = worst.loss.strict
        print(f"All of this held: {held}.")
        if strict <= BROKEN:
            print(
                f"What was missing: {Condition.PAIRS.value}. {1000.0 * strict:.2f} mm were lost while it held, too."
            )
    else:
        said = "No run broke the promise." if law.entry.promises else "d_law fell below d_m in no run."
        print(f"{said} All of this held: {held}.")
        print(f"The nearest approach: d_law − d_m = {1000.0 * worst.loss.nearest:.2f} mm.")
    lost = {condition: max(one.missing[condition] for one in found.values()) for condition in BLAMED}
    print("Lost where a condition was missing: ", end="")
    print(", ".join(f"{condition.value} {1000.0 * most:.0f} mm" for condition, most in lost.items()) + ".")
