"""Run files: recorded inputs (`scenes.inputs_file`) with provenance and outcome as further parts; loading one
recomputes the run and compares.

The provenance names program, libraries and machine, on which a run's last bits may depend.
"""

import json
import platform
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
import pinocchio as pin

from app.recording import outcome as outcomes
from app.version import duet_version
from controllers.errors import BadInputFile, BadSetting, LazyText, joined
from scenes.inputs import Recorded
from scenes.inputs_file import parts_from, recorded_bytes
from scenes.rerun import rerun
from scenes.simulation import Simulation

LONGEST_ENTRY: Final = 40

SHOWN_DIGITS: Final = 12

NAMES: Final[dict[str, str]] = {
    "duet": "Duet",
    "python": "Python",
    "numpy": "numpy",
    "pinocchio": "Pinocchio",
    "system": LazyText("system"),
    "machine": LazyText("processor"),
}

_UNKNOWN: Final = LazyText("unknown")


def made_here() -> dict[str, str]:
    """Key of `NAMES` → version or name here."""
    return {
        "duet": duet_version(),
        "python": platform.python_version(),
        "numpy": np.__version__,
        "pinocchio": str(pin.__version__),
        "system": platform.system(),
        "machine": platform.machine(),
    }


def made_with(file: str, sha256: str) -> LazyText:
    return LazyText(
        "The run was made with {file} (SHA-256 {hash}…) and is replayed, not computed again.",
        file=file,
        hash=sha256[:SHOWN_DIGITS],
    )


def made_from(data: object) -> dict[str, str]:
    """A file's provenance, without unknown entries; never raises."""
    if not isinstance(data, dict):
        return {}
    return {key: str(data[key])[:LONGEST_ENTRY] for key in NAMES if isinstance(data.get(key), str)}


def changed_versions(then: dict[str, str], now: dict[str, str]) -> tuple[LazyText, ...]:
    """Sentences such as "numpy 2.3.1 then, 2.4.0 now" for all differences."""
    return tuple(
        LazyText(
            "{name} {then} then, {now} now",
            name=name,
            then=then.get(key, _UNKNOWN),
            now=now.get(key, _UNKNOWN),
        )
        for key, name in NAMES.items()
        if then.get(key) != now.get(key)
    )


SUFFIX: Final = ".duet.npz"

LONGEST: Final = 660.0
"""Longest run [s]: a little more than a session keeps."""

MADE: Final = "made"

Agreement = Literal["exact", "close", "differs"]


@dataclass(frozen=True)
class SavedRun:
    recorded: Recorded
    outcome: outcomes.RunOutcome
    made: dict[str, str]


@dataclass(frozen=True)
class Loaded:
    """A run file's inputs, and the comparison of a new run with its outcome.

    Attributes:
        verdict: equal bit for bit, within `CLOSE`, or different.
    """

    recorded: Recorded
    verdict: Agreement
    words: LazyText
    comparison: outcomes.Comparison


def saved_bytes(recorded: Recorded, last: bytes | None = None) -> bytes:
    """Content of a file; equal inputs on one machine give equal bytes.

    Args:
        last: newest row of the original history; None for no check.

    Raises:
        BadSetting: the recomputed run ends with another row.
    """
    table = rerun(recorded).table
    if last is not None and table[-1].tobytes() != last:
        raise BadSetting(
            "Computed again, this run gives another result, so it was not saved. Restart it with R."
        )
    outcome = outcomes.outcome_of(table, outcomes.history_columns(Simulation(recorded.settings, 1)))
    made = np.frombuffer(json.dumps(made_here()).encode(), np.uint8)
    return recorded_bytes(recorded, {MADE: made, **outcomes.outcome_arrays(outcome)})


def saved_from(data: bytes, name: str) -> SavedRun:
    """Read a run file.

    Raises:
        BadInputFile: not a run, damaged or impossible.
    """
    recorded, parts = parts_from(data, name)
    if recorded.seconds > LONGEST:
        raise BadInputFile(
            "{name}: is a run of {seconds:.0f} s; at most {most:.0f} s can be made again here.",
            name=name,
            seconds=recorded.seconds,
            most=LONGEST,
        )
    if not {MADE, *outcomes.ARRAYS} <= parts.keys():
        raise BadInputFile(
            "{name}: holds inputs but no results, so nothing can be compared; use it with --inputs.",
            name=name,
        )
    try:
        outcome = outcomes.outcome_from(parts, recorded.steps)
    except BadInputFile as error:
        raise BadInputFile("{name}: {reason}.", name=name, reason=str(error)) from None
    try:
        about = json.loads(np.asarray(parts[MADE]).tobytes().decode())
    except (ValueError, RecursionError):
        about = None
    return SavedRun(recorded, outcome, made_from(about))


def verify(saved: SavedRun) -> Loaded:
    """Recompute and compare.

    Raises:
        BadSetting: impossible here, for example without a robot's package.
        Stopped: see `scenes.wanted`.
    """
    simulation = Simulation(saved.recorded.settings, 1)
    table = rerun(saved.recorded).table
    comparison = outcomes.compare_run(saved.outcome, table, outcomes.history_columns(simulation))
    changes = changed_versions(saved.made, made_here())
    verdict: Agreement = "exact" if comparison.exact else "close" if comparison.close else "differs"
    words = _words(verdict, comparison, changes, simulation.settings.experiment.error_unit)
    if (law := saved.recorded.law) is not None:
        said = made_with(law.file, law.sha256)
        words = said if verdict == "exact" else joined((said, words), " ")
    return Loaded(saved.recorded, verdict, words, comparison)


def load_run(data: bytes, name: str) -> Loaded:
    """Read and verify a file.

    Raises:
        BadInputFile: also if the run is impossible here.
        Stopped: see `scenes.wanted`.
    """
    saved = saved_from(data, name)
    try:
        return verify(saved)
    except BadSetting as error:
        raise BadInputFile("{name}: {reason}", name=name, reason=str(error)) from None


def _words(
    verdict: Agreement, comparison: outcomes.Comparison, changes: tuple[str, ...], error_unit: str
) -> LazyText:
    steps = comparison.steps_then
    if verdict == "exact":
        return LazyText("Repeated: all {steps} steps are the same, to the last bit.", steps=steps)
    parts: list[LazyText] = []
    if verdict == "close":
        parts.append(
            LazyText(
                "Repeated: all {steps} steps agree within {limit:g}, but not to the last bit.",
                steps=steps,
                limit=outcomes.CLOSE,
            )
        )
    else:
        parts.append(LazyText("The repeated run gives another result."))
    if comparison.steps_now != steps:
        parts.append(LazyText("It had {then} steps and has {now} now.", then=steps, now=comparison.steps_now))
    if comparison.first_step is not None:
        number = comparison.first_step + 1
        parts.append(
            LazyText("The first step that differs is number {number} of {steps}.", number=number, steps=steps)
        )
    if comparison.first is not None and comparison.largest is not None:
        parts.append(LazyText("First stored difference: {what}.", what=comparison.first.words(error_unit)))
        if comparison.largest != comparison.first:
            parts.append(LazyText("Largest: {what}.", what=comparison.largest.words(error_unit)))
    if changes:
        parts.append(LazyText("The file was not made here: {what}.", what=joined(changes, "; ")))
    else:
        parts.append(
            LazyText(
                "Program, libraries and machine are the same; the file or the program was changed since."
            )
        )
    return joined(parts, " ")
