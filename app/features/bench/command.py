"""The command `lwr-duet bench`."""

from dataclasses import dataclass
from pathlib import Path
from typing import Final

from app.cli.options import RunOptions, settings_of_options
from app.runtime.terminal import ending_at_once
from controllers.errors import BadSetting
from scenes.settings import RunSettings

LONGEST: Final = 3600.0
"""Longest measurement [s]."""


@dataclass(frozen=True)
class Bench:
    """Measure the time of a step, and what one visitor costs.

    Prints a table; --out saves it as JSON."""

    out: Path | None = None
    """Save the figures to this JSON file."""
    compare: Path | None = None
    """Print ratios to the figures in this JSON file."""
    seconds: float = 10.0
    """How long a visitor is watched [s]."""
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


def bench(command: Bench) -> int:
    """Measure, print and save; return the exit code.

    Raises:
        BadSetting, BadInputFile: a number is out of range, or a file cannot be read or written.
    """
    if command.steps < 1:
        raise BadSetting("--steps must be at least 1.")
    if not 0.0 < command.seconds <= LONGEST:
        raise BadSetting(
            f"seconds = {command.seconds:g} is out of range; give a number above 0 and up to {LONGEST:g}."
        )
    with ending_at_once():
        from app.features.bench.figures_table import printed, ratio_table, read_figures, save_figures
        from app.features.bench.measurements import measured_figures

    arms = {
        key: getattr(command, key)
        for key in ("robot", "robot_left", "robot_right", "hand_left", "hand_right")
    }
    robot = settings_of_options(RunOptions(**arms), RunSettings()).robot
    before = read_figures(command.compare) if command.compare else None
    result = printed(measured_figures(command.steps, command.seconds, robot))
    if before is not None:
        print(ratio_table(result, before))
    if command.out is not None:
        save_figures(result, command.out)
    return 0
