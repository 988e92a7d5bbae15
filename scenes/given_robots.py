"""Robots added at the start of a process, also in its children. Imports nothing slow."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from controllers.errors import BadSetting
from scenes.setting_spec import add_choice, added_choices

if TYPE_CHECKING:
    from scenes.robots.description import Capsule, Robot


class GivenRobot:
    """A choice of the setting `robot`. Child processes unpickle it, so its class must be importable."""

    @property
    def key(self) -> str:
        raise NotImplementedError

    @property
    def label(self) -> str:
        raise NotImplementedError

    @property
    def remark(self) -> str:
        raise NotImplementedError

    @property
    def origin(self) -> Path:
        raise NotImplementedError

    def sources(self) -> tuple[Path, ...]:
        """Python files that its stored data depend on, in addition to `scenes`."""
        raise NotImplementedError

    def column(self) -> float:
        """Height of the column under the robot [m], or 0."""
        raise NotImplementedError

    def fitted(self) -> "tuple[Capsule, ...]":
        """Capsules fitted to its shapes; slow.

        Raises:
            BadInputFile: unreadable shapes.
        """
        raise NotImplementedError

    def made(self, capsules: "tuple[Capsule, ...]") -> "Robot":
        """The robot with these capsules.

        Raises:
            BadInputFile: unreadable.
        """
        raise NotImplementedError

    def shapes(self) -> Iterator[tuple[int, str, Any, Any]]:
        """Visible parts: joint, material, vertices in the joint's frame (k, 3) [m], faces (l, 3).

        Raises:
            BadInputFile: an unreadable shape.
        """
        raise NotImplementedError

    def check_files(self) -> None:
        """Compare its files with those it was made from.

        Raises:
            BadInputFile: a file is missing or changed.
        """
        raise NotImplementedError


GIVEN: Final[dict[str, GivenRobot]] = {}


def give(robot: GivenRobot) -> str:
    """Make a robot a choice in this process; return its key."""
    GIVEN[robot.key] = robot
    add_choice("robot", robot.key, robot.label)
    return robot.key


GivenAtStart = tuple[dict[str, GivenRobot], dict[str, dict[str, str]]]


def given_at_start() -> GivenAtStart:
    return GIVEN, added_choices()


def take_over(given: GivenAtStart) -> None:
    robots, choices = given
    GIVEN.update(robots)
    for key, labels in choices.items():
        for value, label in labels.items():
            add_choice(key, value, label)


RobotReader = Callable[[Path, str], str]
"""Adds the robot of a file: path, name of the hand's link or "" → key."""

_READERS: Final[list[RobotReader]] = []


def add_robot_reader(reader: RobotReader) -> None:
    if reader not in _READERS:
        _READERS.append(reader)


def reads_robots() -> bool:
    return bool(_READERS)


def robot_from_file(path: Path, hand: str) -> str:
    """Add a robot by a `RobotReader`.

    Raises:
        BadSetting: no reader.
        BadInputFile: the file cannot be used.
    """
    if not _READERS:
        raise BadSetting(f"robot = {path}: this Duet reads no robots from files.")
    return _READERS[0](path, hand)
