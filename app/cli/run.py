"""`lwr-duet run`: a simulation without a page."""

import contextlib
import json
import math
import os
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, make_dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from app.cli.options import Flat, StartOptions, settings_of_options
from app.feature import Feature
from app.recording.run_source import RunSource
from app.runtime.progress import progress
from app.runtime.terminal import ending_at_once
from app.version import duet_version
from controllers.errors import BadInputFile, BadSetting
from scenes.files import check_writable, readable, written
from scenes.settings import RunSettings, named_values, specs

if TYPE_CHECKING:
    from scenes.roles import TargetSource


@dataclass(frozen=True)
class RunCommand:
    """Simulate as fast as possible, and print a JSON summary."""

    seconds: float = 46.0
    """Simulated time [s]."""
    inputs: Path | None = None
    """CSV with the header t,x,y,z[,qw,qx,qy,qz]: where the person's hand wants to be; or the recorded inputs of an earlier run. Without
    it the autopilot moves what can be moved."""
    csv: Path | None = None
    """Write every step to this CSV file."""
    settings: Flat[StartOptions] = field(default_factory=StartOptions)  # type: ignore[valid-type]
    """The experiment."""


def run_with(features: Sequence[Feature]) -> type[RunCommand]:
    """Options of the command with those of the features, each a field of the feature's name."""
    kinds = [(one.name, one.run_source()) for one in features if one.run_source is not None]
    added = [(name, Flat[kind], field(default_factory=kind)) for name, kind in kinds]
    return make_dataclass(
        "RunCommand", added, bases=(RunCommand,), frozen=True, namespace={"__doc__": RunCommand.__doc__}
    )


def simulate(command: RunCommand, features: Sequence[Feature]) -> int:
    """Simulate, print the summary and return the exit code.

    Args:
        command: an object of `run_with` the features.

    Raises:
        BadSetting, BadInputFile: an option or a file is not possible, or a law fails in the run.
    """
    with ending_at_once():
        from app.recording.law_heading import law_heading
        from scenes.headless import check_length
        from scenes.headless import run as simulate
        from scenes.recording import write_table
        from scenes.roles import room_of
        from scenes.starts import read_start

    start_file = _start_file(command)
    options = command.settings if start_file is None else replace(command.settings, start=RunSettings().start)
    settings: RunSettings = settings_of_options(options, RunSettings())
    start = None if start_file is None else read_start(start_file, room_of(settings))
    check_length(settings, command.seconds)
    of_features: list[RunSource] = [
        getattr(command, one.name) for one in features if one.run_source is not None
    ]
    given = _given_sources(command, of_features)
    source = _target_source(command, of_features, settings)
    if command.csv is not None:
        check_writable(command.csv, "csv")
        read = (command.inputs, *(path for one in of_features for path in one.read), start_file)
        there = [path for path in read if path is not None and os.path.exists(path)]
        if os.path.exists(command.csv) and any(os.path.samefile(command.csv, path) for path in there):
            raise BadSetting(f"csv = {command.csv}: the run reads this file; give another name.")
    steps = round(command.seconds / settings.dt)
    with contextlib.ExitStack() as stack:
        law = next((made for one in of_features if (made := one.law()) is not None), None)
        if law is not None:
            stack.enter_context(law)
        bar = stack.enter_context(progress(steps, "step", delay=1.0))
        done = simulate(settings, command.seconds, source, start, on_progress=bar.update, law=law)
        if law is not None and law.problem is not None:
            # The arm stood still from there on, so the rest is not a result.
            raise BadInputFile(law.problem.text)
    if command.csv is not None:
        header = {
            "duet": duet_version(),
            **named_values(settings),
            **({"start_file": readable(start_file.name)} if start_file else {}),
            **(law_heading(law.file, law.sha256) if law is not None else {}),
            "seconds": command.seconds,
            "inputs": next((readable(path.name) for path in given.values()), "autopilot"),
        }
        with written(command.csv, "csv") as new, new.open("w", encoding="utf-8", newline="\n") as out:
            write_table(out, done.simulation, done.table, header)
    # JSON has no infinity, the distance in a room without obstacles.
    figures = {key: None if value == math.inf else value for key, value in asdict(done.summary).items()}
    print(json.dumps(figures, indent=2))
    return 0


def _start_file(command: RunCommand) -> Path | None:
    """File of the arms' start posture; None if it is one of the settings' own."""
    name: str = command.settings.start
    choices = specs()["start"].choices
    if name in choices:
        return None
    path = Path(name)
    # Unlike `Path.exists` it takes a text that is too long for a name.
    if not os.path.exists(path):
        raise BadSetting(
            f"start = {name}: there is no such file; give one, or choose from {', '.join(choices)}."
        )
    return path


def _given_sources(command: RunCommand, of_features: Sequence[RunSource]) -> dict[str, Path]:
    """Option → file of the named source; empty for the experiment's own.

    Raises:
        BadSetting: several are named.
    """
    given = {} if command.inputs is None else {"inputs": command.inputs}
    for one in of_features:
        given |= one.given
    if len(given) > 1:
        raise BadSetting(
            f"{' and '.join(f'--{name}' for name in given)} are several sources for one person; give one of them."
        )
    return given


def _target_source(
    command: RunCommand, of_features: Sequence[RunSource], settings: RunSettings
) -> "TargetSource | None":
    from scenes.inputs_file import read_person
    from scenes.recording import Recording
    from scenes.sample_check import check_samples

    if command.inputs is not None:
        person = read_person(command.inputs, settings)
        if isinstance(person, Recording):
            for doubt in check_samples(person, settings, command.seconds, str(command.inputs)):
                print(f"lwr-duet: warning: {doubt}", file=sys.stderr)
        return person
    return next((one.source(settings) for one in of_features if one.given), None)
