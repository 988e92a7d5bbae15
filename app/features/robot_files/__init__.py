"""Robots from URDF files."""

from collections.abc import Mapping
from pathlib import Path
from typing import Final

from app.feature import Command, Feature


def _commands() -> Mapping[str, Command]:
    from app.features.robot_files.command import Robots, robots

    return {"robots": Command(Robots, robots, "show")}


def _read_robot(path: Path, hand: str) -> str:
    # Robots are slow to import.
    from app.features.robot_files.file_robot import register

    return register(path, hand)


ROBOT_FILES: Final = Feature(
    "robot_files", texts=Path(__file__).parent, commands=_commands, robot_reader=_read_robot
)
