"""`lwr-duet falsify`: a search for the run that breaks the promise although its conditions hold."""

from __future__ import annotations

import sys
from dataclasses import dataclass, field
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Final

from app.cli.options import Flat, RunOptions, settings_of_options
from app.cli.sweep import cores, progress
from app.runtime.terminal import INTERRUPTED, ending_at_once
from controllers.errors import BadSetting
from scenes.files import check_writable, written
from scenes.settings import RunSettings, specs

if TYPE_CHECKING:
    from scenes.counterexample import Found

LONGEST: Final = 86_400.0
"""Of a search [s]."""

FASTEST: Final = 20
"""Starts that a process searches in a second at most; more are never drawn up."""


@dataclass(frozen=True)
class Falsify:
    """Search over start postures, a person's ways and speeds for the run in which d_law falls farthest below d_m while w ≤ v, J_d is
    regular, no joint is at its limit and the robot is ideal. Exit code 1 if that is more than 0.1 mm, at dt and at dt/4."""

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
    """Search, print the worst run and what was lost with a condition missing, write the run; return the exit code.

    Raises:
        BadSetting, BadInputFile: an option is not possible.
    """
    with ending_at_once():
        from app.recording.run_file import saved_bytes
        from scenes.children import computed
        from scenes.counterexample import BROKEN, check, replayed, searched
    settings: RunSettings = settings_of_options(command.settings, RunSettings())
    check(settings)
    if not 0.0 < command.seconds <= LONGEST:
        raise BadSetting(f"seconds = {command.seconds:g} is out of range; give a number above 0 and up to {LONGEST:g}.")
    if min(command.starts, command.skip, command.workers) < 0:
        raise BadSetting("falsify needs starts and skip from 0, and workers from 1, or 0 for one a core.")
    if command.out is not None:
        if command.out.suffix != ".npz":
            raise BadSetting(f"out = {command.out}: a run file ends in .npz; give a name like worst.npz.")
        check_writable(command.out, "out")
    begin, workers = monotonic(), command.workers or cores()
    most = command.starts or max(1, round(FASTEST * command.seconds)) * workers
    calls = ((settings, settings.seed, command.skip + place, begin + command.seconds) for place in range(most))
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
    """Return the worst run; of equal ones that of the first start."""
    return max((one for _, one in sorted(found.items())), key=lambda one: one.badness)


def _report(settings: RunSettings, found: dict[int, Found], seconds: float) -> None:
    from scenes.counterexample import BLAMED, BROKEN, FINER
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
            print(f"What was missing: {Condition.PAIRS.value}. {1000.0 * strict:.2f} mm were lost while it held, too.")
    else:
        said = "No run broke the promise." if law.entry.promises else "d_law fell below d_m in no run."
        print(f"{said} All of this held: {held}.")
        print(f"The nearest approach: d_law − d_m = {1000.0 * worst.loss.nearest:.2f} mm.")
    lost = {condition: max(one.missing[condition] for one in found.values()) for condition in BLAMED}
    print("Lost where a condition was missing: ", end="")
    print(", ".join(f"{condition.value} {1000.0 * most:.0f} mm" for condition, most in lost.items()) + ".")
