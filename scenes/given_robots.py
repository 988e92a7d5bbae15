"""Robots that a process is given at its start, in addition to the built-in ones, and hands on to its children. Imports nothing slow."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from controllers.errors import BadSetting
from scenes.setting_spec import add_choice, added_choices

if TYPE_CHECKING:
    from scenes.robots.description import Capsule, Robot


class GivenRobot:
    """A robot that is a choice of the setting `robot` in the processes that know it.

    It is pickled to other processes, so that its class is that of a module which these can import.
    """

    @property
    def key(self) -> str:
        """Name in the setting `robot`."""
        raise NotImplementedError

    @property
    def label(self) -> str:
        """What a person reads for it."""
        raise NotImplementedError

    @property
    def remark(self) -> str:
        """A line for the command line that says what was taken by guess."""
        raise NotImplementedError

    @property
    def origin(self) -> Path:
        """Where its data are from, for errors."""
        raise NotImplementedError

    def sources(self) -> tuple[Path, ...]:
        """Python files that what is stored of the robot depends on, in addition to those of `scenes`."""
        raise NotImplementedError

    def column(self) -> float:
        """Height of the column on which the robot stands [m]; 0 without a column."""
        raise NotImplementedError

    def fitted(self) -> "tuple[Capsule, ...]":
        """Capsules, fitted to its shapes, which takes long.

        Raises:
            BadInputFile: its shapes cannot be read.
        """
        raise NotImplementedError

    def made(self, capsules: "tuple[Capsule, ...]") -> "Robot":
        """The robot with these capsules.

        Raises:
            BadInputFile: it cannot be read.
        """
        raise NotImplementedError

    def shapes(self) -> Iterator[tuple[int, str, Any, Any]]:
        """Everything that is drawn: joint, name of the material, vertices in the joint's frame (k, 3) [m], faces (l, 3).

        Raises:
            BadInputFile: a shape cannot be read.
        """
        raise NotImplementedError

    def check_files(self) -> None:
        """Compare the files that stay where they are with those that the robot was made from; on another machine they may differ.

        Raises:
            BadInputFile: one is missing, or has another content.
        """
        raise NotImplementedError


GIVEN: Final[dict[str, GivenRobot]] = {}
"""Key → robot, of all that were given."""


def give(robot: GivenRobot) -> str:
    """Make a robot a choice of the setting `robot` in this process, and return its key."""
    GIVEN[robot.key] = robot
    add_choice("robot", robot.key, robot.label)
    return robot.key


GivenAtStart = tuple[dict[str, GivenRobot], dict[str, dict[str, str]]]


def given_at_start() -> GivenAtStart:
    """Robots and choices that only this process knows, for the processes that it starts."""
    return GIVEN, added_choices()


def take_over(given: GivenAtStart) -> None:
    """Know in a started process what `given_at_start` returned in the one that started it."""
    robots, choices = given
    GIVEN.update(robots)
    for key, labels in choices.items():
        for value, label in labels.items():
            add_choice(key, value, label)


RobotReader = Callable[[Path, str], str]
"""Gives the robot of a file: path, name of the link that is the hand or "" → key."""

_READERS: Final[list[RobotReader]] = []


def add_robot_reader(reader: RobotReader) -> None:
    """Let the command line name robots by files that this function reads."""
    if reader not in _READERS:
        _READERS.append(reader)


def reads_robots() -> bool:
    """True if the command line may name robots by files."""
    return bool(_READERS)


def robot_from_file(path: Path, hand: str) -> str:
    """Give the robot of a file, and return its key.

    Raises:
        BadSetting: no part of this program reads robots.
        BadInputFile: the file cannot be used.
    """
    if not _READERS:
        raise BadSetting(f"robot = {path}: this Duet reads no robots from files.")
    return _READERS[0](path, hand)
