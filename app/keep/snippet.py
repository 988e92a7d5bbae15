"""A run as a few lines of Python that make it again without a page."""

import base64
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from typing import Any, Final

from scenes.inputs import Recorded, encoded
from scenes.inputs_file import recorded_bytes
from scenes.rerun import LOOK, Stopped, never
from scenes.settings import RunSettings
from scenes.simulation import Simulation

MOST_CHARACTERS: Final = 40_000
"""Of recorded inputs in the text; more than that are read from a file."""

SECONDS: Final = 20.0
"""Length of a run of which nothing is recorded [s]."""


def as_python(
    settings: RunSettings, recorded: Recorded | None = None, file: str = "run.duet.npz", stopped: Callable[[], bool] = never
) -> str:
    """Return a program of at most 15 lines that prints the run's summary, for a folder where Duet is installed.

    Where the autopilot did everything from a fresh start, the settings say it all. Otherwise the inputs stand in the text, or, if
    there are too many, the program reads them from a saved run.

    Args:
        settings: of a run of which nothing is recorded.
        recorded: the run; None for a fresh start with the settings.
        file: name of the saved run.
        stopped: asked now and then; when it says True, everything ends with `Stopped`.

    Raises:
        Stopped: see there.
    """
    if recorded is None:
        return _fresh(settings, SECONDS)
    if is_fresh(recorded, stopped):
        return _fresh(recorded.settings, recorded.seconds)
    text = base64.b64encode(recorded_bytes(recorded)).decode()
    about = f"# {recorded.seconds:.6g} s from t = {recorded.begin:.6g} s on: the state at the beginning, all inputs and settings."
    if len(text) > MOST_CHARACTERS:
        return _lines(
            "from pathlib import Path",
            "",
            "from scenes.inputs_file import read_recorded",
            "from scenes.rerun import rerun",
            "",
            about + " Save the run under this name first.",
            f"recorded = read_recorded(Path({file!r}))",
            *_AGAIN,
        )
    return _lines(
        "import base64",
        "",
        "from scenes.inputs_file import recorded_from",
        "from scenes.rerun import rerun",
        "",
        about,
        f'inputs = "{text}"',
        'recorded = recorded_from(base64.b64decode(inputs), "the inputs above")',
        *_AGAIN,
    )


_AGAIN: Final = (
    "again = rerun(recorded)",
    "print(again.summary)",
    "# again.table has one row a step; see scenes.history.SCALARS.",
)


def is_fresh(recorded: Recorded, stopped: Callable[[], bool] = never) -> bool:
    """Return whether a piece is a whole run, from its start, of constant settings, in which the autopilot did everything.

    Args:
        stopped: see `as_python`.

    Raises:
        Stopped: see there.
    """
    stretch, *others = recorded.stretches
    if recorded.snapshot.steps or others:
        return False
    simulation = Simulation(recorded.settings, 1)
    start, there = simulation.snapshot(), recorded.snapshot
    if start.positions.tobytes() != there.positions.tobytes() or there.velocities.any():
        return False
    person = simulation.person()
    step, time = 0, 0.0
    for target, count in stretch.targets.runs():
        wanted = encoded(target)
        for _ in range(count):
            if step % LOOK == 0 and stopped():
                raise Stopped
            if encoded(person.target(time)) != wanted:
                return False
            step, time = step + 1, time + recorded.dt
    return True


def _fresh(settings: RunSettings, seconds: float) -> str:
    made = settings_python(settings)
    names = "LawSettings, RunSettings" if "LawSettings(" in made else "RunSettings"
    return _lines(
        "from scenes.headless import run",
        f"from scenes.settings import {names}",
        "",
        f"settings = {made}",
        f"done = run(settings, seconds={seconds!r})",
        "print(done.summary)",
        "# done.table has one row a step; see scenes.history.SCALARS.",
    )


def settings_python(settings: Any) -> str:
    """Return an expression for a tree of settings; what is as usual is left out."""
    usual = type(settings)()
    parts: list[str] = []
    for f in fields(settings):
        value = getattr(settings, f.name)
        if value != getattr(usual, f.name):
            parts.append(f"{f.name}={settings_python(value) if is_dataclass(value) else repr(value)}")
    return f"{type(settings).__name__}({', '.join(parts)})"


def _lines(*lines: str) -> str:
    return "\n".join(lines) + "\n"
