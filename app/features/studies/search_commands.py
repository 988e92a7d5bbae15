"""`lwr-duet hunt` and `lwr-duet falsify`."""

from __future__ import annotations

import math
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
from scenes.experiments import Series
from scenes.files import check_writable, written
from scenes.quantities import DISTANCE
from scenes.settings import RunSettings, specs, values

if TYPE_CHECKING:
    from app.features.studies.counterexample import Found
    from scenes.random_draws import RandomRun
    from scenes.random_runs import RunVerdict


@dataclass(frozen=True)
class Hunt:
    """Make random runs, and look for one that breaks a bound.

    That is a number that is not finite, a stop or a top speed that is passed, d_law > d, an arm that gets inside of what
    it glides along, or the promise d_law ≥ d_m broken with every condition met, by more than a time step explains. Exit
    code 1 if a run breaks one."""

    runs: int = 1500
    """How many."""
    seed: int = 1
    """Seed of the settings and start postures: the same seed draws the same runs."""
    series: Series = "usual"
    """usual: all experiments but another first task; first-tasks: that one, with h and h_m in the unit of each; world: the usual ones
    with arms that glide along table, stand, floor and their own links."""
    seconds: float = 6.0
    """Simulated time of each run [s]."""
    out: Path = Path(".")
    """Folder for the start postures and the ways of the hand of broken runs."""
    workers: int = 0
    """Processes; 0 takes one a core. The verdicts do not depend on it."""


def hunt(command: Hunt) -> int:
    """Returns the exit code; raises `BadSetting`."""
    with ending_at_once():
        from scenes.children import computed
        from scenes.random_draws import random_run
        from scenes.random_runs import run_verdict
    if command.runs < 1 or command.seed < 0 or command.workers < 0:
        raise BadSetting("hunt needs at least 1 run, a seed from 0, and workers from 1, or 0 for one a core.")
    if not 0.0 < command.seconds <= 600.0:
        raise BadSetting(
            f"seconds = {command.seconds:g} is out of range; give a number above 0 and up to 600."
        )
    if not os.path.isdir(command.out):
        raise BadSetting(f"out = {command.out}: there is no such folder; make it first.")
    calls = [(command.seed, index, command.seconds, command.series) for index in range(command.runs)]
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
        print(f"  {_repeating(command, found.index, random_run(command.seed, found.index, command.series))}")
    _summarise(command, verdicts, len(broken))
    if interrupted:
        print("Interrupted; the runs that were not made are not counted.", file=sys.stderr)
        return INTERRUPTED
    return 1 if broken else 0


def _summarise(command: Hunt, verdicts: list[RunVerdict], broken: int) -> None:
    from scenes.random_runs import EXCESS

    symbol = "h" if command.series == "first-tasks" else DISTANCE.symbol
    promised = [found for found in verdicts if found.promised]
    print(
        f"{len(verdicts)} runs, {broken} broken. The law promises {symbol} ≥ {symbol}_law ≥ {symbol}_m in {len(promised)}."
    )
    print(
        f"{symbol}_law is below {symbol}_m at some time in {sum(found.margin < 0.0 for found in promised)} of these."
    )
    # Thousandths of different units are not compared.
    for unit in dict.fromkeys(found.kept.page_unit for found in promised):
        excesses = [found.excesses for found in promised if found.kept.page_unit == unit]
        fallen = [one for one in excesses if len(one) > 1]
        print(
            f"It falls there by more than {1e3 * EXCESS:g} {unit} with every condition met in {len(fallen)}",
            end="",
        )
        if fallen:
            at_dt, at_last = (1e3 * max(one[i] for one in fallen) for i in (0, -1))
            print(
                f", by {at_dt:.3g} {unit} at most; by {at_last:.3g} {unit} at the smallest of its time steps, an eighth or less",
                end="",
            )
        print(".")
    gliding = [found.clear for found in verdicts if math.isfinite(found.clear)]
    if gliding:
        inside = sum(clear < 0.0 for clear in gliding)
        print(f"Arms glide along things in {len(gliding)}, and get inside of one in {inside}", end="")
        print(f"; the least distance is {1e3 * min(gliding):.1f} mm.")


def _repeating(command: Hunt, index: int, random: RandomRun) -> str:
    """Command line that repeats a run; writes its input files."""
    words = ["lwr-duet", "run", "--seconds", f"{command.seconds:g}"]
    usual = values(RunSettings())
    given = values(random.settings)
    if random.start is not None:
        path = command.out / f"hunt-{command.seed}-{index}.txt"
        with written(path, "out") as new:
            new.write_text(" ".join(map(repr, random.start.tolist())) + "\n", encoding="utf-8")
        given["start"] = path
    if random.hand is not None:
        path = command.out / f"hunt-{command.seed}-{index}.csv"
        rows = zip(random.hand.times.tolist(), *random.hand.positions.T.tolist(), strict=True)
        with written(path, "out") as new:
            lines = ["t,x,y,z", *(",".join(map(repr, row)) for row in rows)]
            new.write_text("\n".join(lines) + "\n", encoding="utf-8")
        given["inputs"] = path
    for key, value in given.items():
        option = f"--{key.replace('_', '-')}"
        if isinstance(value, bool):
            words += [option] * value
        elif value != usual.get(key):
            words += [option, str(value)]
    return shlex.join(words)


LONGEST: Final = 86_400.0
"""Longest search [s]."""

FASTEST: Final = 20
"""Most starts per process and second."""


@dataclass(frozen=True)
class Falsify:
    """Search for the run that breaks the promise d_law ≥ d_m most.

    Varies start postures, and a person's ways and speeds, for the run in which d_law falls farthest below d_m while
    w ≤ v, J_d is regular, no joint is at its limit and the robot is ideal. Exit code 1 if that is more than 0.1 mm,
    at dt and at dt/4. In the scene first_task this is h_law and h_m, in the unit of the first task, and the person moves the wall,
    too; of several stages each is checked, and the broken one named."""

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
    """Returns the exit code; raises `BadSetting` or `BadInputFile`."""
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
                most_lost = 1000.0 * max(each.loss.lost for each in found.values())
                bar.set_postfix_str(f"{most_lost:.1f} {settings.quantity.page_unit} lost")
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
        print(f"Interrupted; --seed {settings.seed} --skip {done} continues from here.", file=sys.stderr)
        return INTERRUPTED
    return 1 if _worst(found).loss.lost > BROKEN else 0


def _worst(found: dict[int, Found]) -> Found:
    """Worst run; the earliest of equal ones."""
    return max((one for _, one in sorted(found.items())), key=lambda one: one.badness)


def _report(settings: RunSettings, found: dict[int, Found], seconds: float) -> None:
    from app.features.studies.counterexample import BLAMED, BROKEN, FINER
    from scenes.promise import Condition

    worst, law, kept = _worst(found), settings.law, settings.quantity
    symbol, least, unit = kept.seen, kept.critical, kept.page_unit
    if settings.stages:
        stage = settings.stages[worst.loss.stage]
        symbol, least, unit = f"{stage.label}: {stage.symbol}", stage.critical, stage.page_unit
    runs, pairs = sum(one.runs for one in found.values()), specs()["pairs"].options()[law.pairs]
    name = settings.experiment.label if kept is DISTANCE else f"{settings.experiment.label}: {kept.label}"
    print(f"{len(found)} start postures, {runs} runs in {seconds:.0f} s.")
    held = ", ".join(condition.value for condition in (*BLAMED, Condition.ROBOT))
    if settings.stages:
        pairs, held = "by stages", f"{held}, no later stage acting against it"
    print(f"{name}: {law.entry.label}, {pairs}, v = {law.nominal_velocity:g} {kept.rate_unit}.")
    if settings.stages:
        print(f"Each stage is checked: {', '.join(stage.label for stage in settings.stages)}.")
    if not law.entry.promises:
        print("This law makes no promise.")
    if worst.loss.lost > BROKEN:
        said = f"The promise breaks: {symbol}" if law.entry.promises else symbol
        print(f"{said} falls {1000.0 * worst.loss.lost:.1f} {unit} below {least}, at dt and at dt/{FINER}.")
        strict = worst.loss.strict
        print(f"All of this held: {held}.")
        if strict <= BROKEN:
            print(
                f"What was missing: {Condition.PAIRS.value}. {1000.0 * strict:.2f} {unit} were lost while it held, too."
            )
    else:
        said = (
            "No run broke the promise." if law.entry.promises else f"{symbol} fell below {least} in no run."
        )
        print(f"{said} All of this held: {held}.")
        print(f"The nearest approach: {symbol} − {least} = {1000.0 * worst.loss.nearest:.2f} {unit}.")
    lost = {condition: max(one.missing[condition] for one in found.values()) for condition in BLAMED}
    print("Lost where a condition was missing: ", end="")
    print(
        ", ".join(
            f"{condition.value} {1000.0 * most:.0f} {kept.page_unit}" for condition, most in lost.items()
        )
        + "."
    )
