"""`lwr-duet bench`: what a step and a visitor cost."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from app.cli.options import RunOptions, settings_of_options
from app.runtime.terminal import ending_at_once
from controllers.errors import BadSetting
from scenes.files import written
from scenes.settings import RunSettings

SECONDS: Final = 10.0
FAIR: Final = 2.0
"""How long a visitor is watched [s], and how long while another one disturbs the server."""
LONGEST: Final = 3600.0
"""The longest measurement [s]."""


@dataclass(frozen=True)
class Bench:
    """Measure the step, and what a visitor costs the server; print a table and save JSON."""

    out: Path | None = None
    """Save the figures to this JSON file."""
    compare: Path | None = None
    """Print ratios to the figures in this JSON file."""
    seconds: float = 0.0
    """How long a visitor is watched [s]; 0 takes 10, and 2 for each row of --fair, which then ends within two minutes."""
    steps: int = 9200
    """Steps measured of each scene."""
    robot: str = "lwr"
    """The arms of the measured steps: a name, as on the page, or a URDF file."""
    robot_left: str = ""
    """The left arm where the two differ."""
    robot_right: str = ""
    """The right arm where the two differ."""
    hand_left: str = ""
    """The link that is the hand of the left arm, if that is from a URDF file."""
    hand_right: str = ""
    """The link that is the hand of the right arm."""
    peers: bool = False
    """Instead, the hold experiment beside pink, mink, embodik and roboplan: the same arms and inputs, interleaved (needs the
    extra `peers`)."""
    fair: bool = False
    """Instead, what a visitor's page has left while another floods the server, sends heavy messages, or comes with a class."""
    sessions: tuple[int, ...] = ()
    """Instead, the CPU, the memory and the slowest visitor's frames of a server with so many private sessions, such as 8 16 30 60."""


def bench(command: Bench) -> int:
    """Measure, print and save; return the exit code.

    Raises:
        BadSetting, BadInputFile: the extra is not installed, or a file cannot be read or written.
    """
    if any(count < 1 for count in command.sessions):
        raise BadSetting("--sessions must be at least 1.")
    if command.steps < 1:
        raise BadSetting("--steps must be at least 1.")
    if not 0.0 <= command.seconds <= LONGEST:
        raise BadSetting(f"seconds = {command.seconds:g} is out of range; give 0 to {LONGEST:g}.")
    with ending_at_once():
        from app.features.bench.fairness import measure_fairness
        from app.features.bench.measurements import measure_capacity, measured_figures, printed, ratio_table, read_figures
        from app.features.bench.peers import measure_peers, peers_table

    arms = {key: getattr(command, key) for key in ("robot", "robot_left", "robot_right", "hand_left", "hand_right")}
    robot = settings_of_options(RunOptions(**arms), RunSettings()).robot
    before = read_figures(command.compare) if command.compare else None
    if command.peers:
        result = measure_peers(command.steps)
        print(peers_table(result))
    elif command.fair:
        result = printed(measure_fairness(command.seconds or FAIR))
    else:
        seconds = command.seconds or SECONDS
        rows = (
            measure_capacity(command.sessions, seconds) if command.sessions else measured_figures(command.steps, seconds, robot)
        )
        result = printed(rows)
    if before is not None:
        print(ratio_table(result, before))
    if command.out is not None:
        with written(command.out, "out") as new:
            new.write_text(json.dumps(result, indent=2) + "\n", encoding="utf-8", newline="\n")
    return 0
