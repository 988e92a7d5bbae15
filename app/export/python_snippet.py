"""A piece of a run as a few lines of Python that make it again without a page, and plot it."""

import base64
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from typing import Any, Final, NamedTuple

from app.recording.run_file import SUFFIX, saved_bytes
from app.session.relevant_settings import OBSTACLE
from scenes.experiments import EXPERIMENTS
from scenes.inputs import Recorded, encoded
from scenes.inputs_file import recorded_bytes
from scenes.rerun import LOOK, Stopped, never, newest_piece, newest_steps
from scenes.settings import RunSettings
from scenes.simulation import Simulation

MOST_CHARACTERS: Final = 40_000
"""Of recorded inputs in the text; more than that are read from a file."""


class Snippet(NamedTuple):
    """A program, and what it reads.

    Attributes:
        text: of it.
        inputs: content of the file that it names, beside which it is to be run; None if it needs none.
    """

    text: str
    inputs: bytes | None = None


def as_python(
    whole: Recorded, recorded: Recorded, seconds: float, name: str = "run", stopped: Callable[[], bool] = never
) -> Snippet:
    """Return a short program that makes the last seconds of a run again, prints their summary and plots them.

    It runs where Duet is installed. A run of the autopilot from its start needs the settings alone. Any other starts from a stored state
    with the recorded inputs, in the text or, if they are too many, in a file beside it.

    Args:
        whole: the whole recorded run.
        recorded: its newest piece, at least as long as what is wanted, or all that there is.
        seconds: what is wanted of it.
        name: of the files that belong to the program, without an ending.
        stopped: asked now and then; when it says True, everything ends with `Stopped`.
    """
    steps = newest_steps(recorded, seconds)
    if is_fresh(whole, stopped):
        lines = _fresh(whole.settings, whole.seconds, whole.steps, steps)
        return Snippet(_lines(*lines, *_plot(whole.settings, name, "[settings.law.critical_distance] * len(table)")))
    piece = newest_piece(recorded, seconds, stopped)
    data = recorded_bytes(piece)
    text = base64.b64encode(data).decode()
    span = f"from t = {piece.begin:.6g} s to {piece.begin + piece.seconds:.6g} s"
    about = f"# The run {span}: its state at the beginning, all inputs and settings"
    if len(text) > MOST_CHARACTERS:
        file = name + SUFFIX
        head = (
            "from pathlib import Path",
            "",
            *_PLOT,
            _COLUMN,
            "from scenes.inputs_file import read_recorded",
            "from scenes.rerun import rerun",
            "",
            f"{about},",
            "# which stand in a file that was saved with these lines.",
            f"recorded = read_recorded(Path({file!r}))",
        )
        inputs = saved_bytes(piece, stopped=stopped)
    else:
        head = (
            "import base64",
            "",
            *_PLOT,
            _COLUMN,
            "from scenes.inputs_file import recorded_from",
            "from scenes.rerun import rerun",
            "",
            f"{about}.",
            f'inputs = "{text}"',
            'recorded = recorded_from(base64.b64decode(inputs), "the inputs above")',
        )
        inputs = None
    d_m = "[part.settings.law.critical_distance for part in recorded.stretches for _ in range(part.targets.steps)]"
    return Snippet(_lines(*head, *_AGAIN, *_plot(piece.settings, name, d_m)), inputs)


_PLOT: Final = ("import matplotlib.pyplot as plt", "")
_COLUMN: Final = "from scenes.history import COLUMN"

_AGAIN: Final = (
    "again = rerun(recorded)",
    "print(again.summary)",
    "table = again.table  # one row a step, see scenes.history.SCALARS",
)


def _plot(settings: RunSettings, name: str, d_m: str) -> tuple[str, ...]:
    """Return the lines that draw d over time with d_m (an expression), and e²; of an arm alone, e²."""
    unit = EXPERIMENTS[settings.scene].error_unit
    end = (
        f'lower.set(xlabel="t [s]", ylabel="e² [{unit}]")',
        f'figure.savefig("{name}.png")  # A notebook shows it by itself, too.',
    )
    if settings.scene not in OBSTACLE:
        return (
            "",
            't, e2 = table[:, COLUMN["t"]], table[:, COLUMN["e2"]]',
            "figure, lower = plt.subplots()",
            "lower.plot(t, e2)",
            *end,
        )
    return (
        "",
        f"d_m = {d_m}",
        't, d, e2 = (table[:, COLUMN[name]] for name in ("t", "d", "e2"))',
        "figure, (upper, lower) = plt.subplots(2, sharex=True)",
        'upper.plot(t, 1000 * d, label="d")',
        'upper.plot(t, [1000 * each for each in d_m], "--", label="$d_m$")',
        'upper.set(ylabel="distance [mm]")',
        "upper.legend()",
        "lower.plot(t, e2)",
        *end,
    )


def is_fresh(recorded: Recorded, stopped: Callable[[], bool] = never) -> bool:
    """Return whether a piece is a whole run, from its start, of constant settings, in which the autopilot did everything.

    Args:
        stopped: see `as_python`.
    """
    stretch, *others = recorded.stretches
    if recorded.snapshot.steps or others:
        return False
    simulation = Simulation(recorded.settings, 1)
    start, there = simulation.snapshot(), recorded.snapshot
    if start.positions.tobytes() != there.positions.tobytes() or there.velocities.any():
        return False
    person = simulation.source()
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


def _fresh(settings: RunSettings, seconds: float, made: int, steps: int) -> tuple[str, ...]:
    """Return the lines that make a run of so many seconds and steps from its start, and keep the last steps of it."""
    given = settings_python(settings)
    names = "LawSettings, RunSettings" if "LawSettings(" in given else "RunSettings"
    kept = f", and its last {steps * settings.dt:.6g} s are kept" if steps < made else ""
    return (
        *_PLOT,
        "from scenes.headless import run, summarise",
        _COLUMN,
        f"from scenes.settings import {names}",
        "",
        f"settings = {given}",
        f"# The settings say it all: the run is made from its start{kept}.",
        f"done = run(settings, seconds={seconds!r})",
        f"table = done.table[-{steps}:]  # one row a step, see scenes.history.SCALARS",
        "print(summarise(done.simulation, table))",
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
