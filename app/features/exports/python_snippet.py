"""A piece of a run as a short Python program."""

import base64
from dataclasses import fields, is_dataclass
from typing import Any, Final, NamedTuple

from app.recording.run_file import SUFFIX, saved_bytes
from scenes.inputs import Recorded, encoded
from scenes.inputs_file import recorded_bytes
from scenes.rerun import LOOK, newest_piece, newest_steps
from scenes.settings import RunSettings
from scenes.simulation import Simulation
from scenes.wanted import while_wanted

MOST_CHARACTERS: Final = 40_000
"""Larger inputs are read from a file."""


class Snippet(NamedTuple):
    """A program, and the file that it reads, if any."""

    text: str
    inputs: bytes | None = None


def as_python(whole: Recorded, recorded: Recorded, seconds: float, name: str = "run") -> Snippet:
    """Program that computes the last `seconds` [s] of a run again.

    A fresh run needs only its settings; any other starts from a stored state with the recorded inputs.
    `recorded`: newest piece of `whole`.
    """
    steps = newest_steps(recorded, seconds)
    if is_fresh(whole):
        run = whole.settings
        given = settings_python(run)
        text = FRESH.format(
            names="LawSettings, RunSettings" if "LawSettings(" in given else "RunSettings",
            given=given,
            kept=f", and its last {steps * run.dt:.6g} s are kept" if steps < whole.steps else "",
            seconds=whole.seconds,
            steps=steps,
        )
        return Snippet(text + run_plot(run, name, "[settings.law.critical_distance] * len(table)"))
    piece = newest_piece(recorded, seconds)
    text, inputs = base64.b64encode(recorded_bytes(piece)).decode(), None
    template = IN_TEXT
    if len(text) > MOST_CHARACTERS:
        template, inputs = IN_FILE, saved_bytes(piece)
    head = template.format(begin=piece.begin, end=piece.begin + piece.seconds, text=text, file=name + SUFFIX)
    d_m = "[part.settings.law.critical_distance for part in recorded.stretches for _ in range(part.targets.steps)]"
    return Snippet(head + AGAIN + run_plot(piece.settings, name, d_m), inputs)


FRESH: Final = """\
import matplotlib.pyplot as plt

from scenes.headless import run, summarise
from scenes.history import COLUMN
from scenes.settings import {names}

settings = {given}
# The settings say it all: the run is made from its start{kept}.
done = run(settings, seconds={seconds!r})
table = done.table[-{steps}:]  # one row a step, see scenes.history.SCALARS
print(summarise(done.simulation, table))
"""

IN_TEXT: Final = """\
import base64

import matplotlib.pyplot as plt

from scenes.history import COLUMN
from scenes.inputs_file import recorded_from
from scenes.rerun import rerun

# The run from t = {begin:.6g} s to {end:.6g} s: its state at the beginning, all inputs and settings.
inputs = "{text}"
recorded = recorded_from(base64.b64decode(inputs), "the inputs above")
"""

IN_FILE: Final = """\
from pathlib import Path

import matplotlib.pyplot as plt

from scenes.history import COLUMN
from scenes.inputs_file import read_recorded
from scenes.rerun import rerun

# The run from t = {begin:.6g} s to {end:.6g} s: its state at the beginning, all inputs and settings,
# which stand in a file that was saved with these lines.
recorded = read_recorded(Path({file!r}))
"""

AGAIN: Final = """\
again = rerun(recorded)
print(again.summary)
table = again.table  # one row a step, see scenes.history.SCALARS
"""

DISTANCE_AND_ERROR: Final = """
d_m = {d_m}
t, d, e2 = (table[:, COLUMN[name]] for name in ("t", "d", "e2"))
figure, (upper, lower) = plt.subplots(2, sharex=True)
upper.plot(t, 1000 * d, label="{symbol}")
upper.plot(t, [1000 * each for each in d_m], "--", label="${symbol}_m$")
upper.set(ylabel="{short} [{page_unit}]")
upper.legend()
"""

ERROR: Final = """
t, e2 = table[:, COLUMN["t"]], table[:, COLUMN["e2"]]
figure, lower = plt.subplots()
"""

END: Final = """\
lower.plot(t, e2)
lower.set(xlabel="t [s]", ylabel="e² [{unit}]")
figure.savefig("{name}.png")  # A notebook shows it by itself, too.
"""


def run_plot(settings: RunSettings, name: str, d_m: str) -> str:
    """Lines that plot d with d_m (an expression), and e²."""
    kept = settings.quantity
    words = {"symbol": kept.symbol, "short": kept.short, "page_unit": kept.page_unit}
    above = (
        DISTANCE_AND_ERROR.format(d_m=d_m, **words) if settings.experiment.obstacle != "nothing" else ERROR
    )
    return above + END.format(unit=settings.experiment.error_unit, name=name)


def is_fresh(recorded: Recorded) -> bool:
    """True for a whole run with constant settings, moved by the autopilot alone."""
    if recorded.snapshot.steps or len(recorded.stretches) > 1:
        return False
    simulation = Simulation(recorded.settings, 1)
    start, there = simulation.snapshot(), recorded.snapshot
    if start.positions.tobytes() != there.positions.tobytes() or there.velocities.any():
        return False
    person = simulation.source()
    time = 0.0
    for target in while_wanted(recorded.targets(), LOOK):
        if encoded(person.target(time)) != encoded(target):
            return False
        time += recorded.settings.dt
    return True


def settings_python(settings: Any) -> str:
    """Expression for a tree of settings without defaults."""
    usual = type(settings)()
    parts: list[str] = []
    for f in fields(settings):
        value = getattr(settings, f.name)
        if value != getattr(usual, f.name):
            parts.append(f"{f.name}={settings_python(value) if is_dataclass(value) else repr(value)}")
    return f"{type(settings).__name__}({', '.join(parts)})"
