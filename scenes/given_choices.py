"""Values of the settings `robot` and `rig` that the command line gives at the start: pairs of makes, files, bases of one's own."""

import re
from dataclasses import replace
from itertools import permutations
from typing import Final

from controllers.errors import LazyText
from scenes.setting_spec import Spec

PAIR: Final = "_"
"""Between the names of two makes, left first, in one value of the setting `robot`."""

FILE_NAME: Final = re.compile(r"([a-z0-9-]{1,24})-([0-9a-f]{12})")
"""Of a robot from a file: the file's own name and the beginning of the hash of its content."""

_NUMBERS: Final = r"-?[0-9.]{1,8}(?:,-?[0-9.]{1,8}){3}"
BASES_NAME: Final = re.compile(rf"{_NUMBERS}:{_NUMBERS}")
"""Of a rig with given bases: x,y,z,yaw of the left and of the right one [m, degrees]."""

_ADDED: Final[dict[str, dict[str, str]]] = {}
"""Key → value → label of the choices that were given at the start of this process."""


def add_choice(key: str, value: str, label: str) -> None:
    """Make one more value possible for a setting, in this process; only the command line may ask for it, never a visitor."""
    _ADDED.setdefault(key, {})[value] = label


def added_choices() -> dict[str, dict[str, str]]:
    """Return key → value → label of what `add_choice` has added."""
    return _ADDED


def makes(robot: str) -> tuple[str, str]:
    """Return the names of the left and the right arm's make."""
    left, _, right = robot.partition(PAIR)
    return left, right or left


def with_added(spec: Spec) -> Spec:
    """Return the spec with the choices of this process: pairs of different makes, and what was given at its start."""
    if spec.key not in ("robot", "rig"):
        return spec
    known = {**spec.options(), **_ADDED.get(spec.key, {})}
    if spec.key == "robot":
        known |= {f"{a}{PAIR}{b}": f"{known[a]} | {known[b]}" for a, b in permutations(tuple(known), 2)}
    return replace(spec, options=known.copy)


def start_remedy(value: str) -> LazyText | None:
    """Return how to start Duet so that a value is possible that another start had; None if it never is."""
    for make in makes(value):
        if (found := FILE_NAME.fullmatch(make)) and make not in _ADDED.get("robot", {}):
            return LazyText(
                "The robot {name} is from a URDF file that was not given here: start Duet with --robot and the same file, "
                "{stem}.urdf, unchanged.",
                name=make,
                stem=found[1],
            )
    if BASES_NAME.fullmatch(value):
        left, right = value.split(":")
        return LazyText(
            "These bases were not given here: start Duet with --base-left={left} --base-right={right}.", left=left, right=right
        )
    return None
