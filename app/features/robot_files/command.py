"""`lwr-duet robots`."""

from dataclasses import dataclass
from typing import get_args

from app.runtime.terminal import ending_at_once
from controllers.errors import DuetError
from scenes.settings import RobotName


@dataclass(frozen=True)
class Robots:
    """List the arms that Duet knows, and the URDF files that fit.

    Every URDF file of example-robot-data is listed, with what keeps it from being an arm."""


def robots(command: Robots) -> int:
    del command
    with ending_at_once():
        from app.features.robot_files.robot_file import robot_file
        from scenes.robots import robot
        from scenes.robots.example_data import urdf_files

    for name in get_args(RobotName):
        try:
            made = robot(name)
            print(f"{name:6s} {made.name}, {made.model.nv} joints")
        except DuetError as error:
            print(f"{name:6s} {error}")
    try:
        files = urdf_files()
    except DuetError as error:
        print(error)
        return 0
    refused: list[str] = []
    for path in files:
        try:
            print(f"--robot {path}   {len(robot_file(path).chain.joints)} joints")
        except DuetError as error:
            refused.append(f"no: {error}")
    print(*refused, sep="\n")
    return 0
