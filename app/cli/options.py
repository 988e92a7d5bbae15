"""Every setting of a tree as an option of a command."""

import sys
from collections.abc import Collection, Mapping
from dataclasses import asdict, field, fields, make_dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any, Final, cast, get_args

import tyro

from app.settings import Settings
from controllers.errors import BadSetting
from scenes.given_robots import GIVEN, reads_robots, robot_from_file
from scenes.setting_spec import PAIR, Spec, makes
from scenes.settings import RobotName, RunSettings, changed, specs, values

NO_WORLD: Final = "no_world"
"""Name of the option of a page that says that arms do not glide."""

PLACES: Final[dict[str, tuple[str, str]]] = {
    "robot_left": ("NAME|FILE", "The left arm where the two differ: a name, or a URDF file."),
    "robot_right": ("NAME|FILE", "The right arm where the two differ: a name, or a URDF file."),
    "hand_left": (
        "LINK",
        "The link that is the hand of the left arm, if that is from a URDF file; without it the likely one, which is said.",
    ),
    "hand_right": ("LINK", "The link that is the hand of the right arm."),
    "base_left": (
        "X,Y,Z,YAW",
        "Where the left arm stands instead of on a rig [m, degrees]: --base-left=-0.5,0,0.75,0.",
    ),
    "base_right": ("X,Y,Z,YAW", "Where the right arm stands instead of on a rig [m, degrees]."),
}


def _options(tree: type, name: str, files: Mapping[str, str] = MappingProxyType({})) -> type:
    """A dataclass with a text option for every setting of a tree; a bad text gets the error that names the
    choices, as in a link.

    Args:
        files: key of a setting that may be a file instead → its content.
    """
    fields: list[tuple[str, Any, Any]] = []
    for key, spec in specs(tree).items():
        default = values(tree())[key]
        text, metavar = _help(spec), _metavar(spec, default)
        if key in files:
            text, metavar = f"{text} Or a file: {files[key]}", f"{metavar}|FILE"
        is_flag = isinstance(default, bool)
        about = tyro.conf.arg(name=key.replace("_", "-"), help=text, metavar=None if is_flag else metavar)
        kind: Any = bool if is_flag else str
        fields.append(
            (
                key,
                Annotated[kind, about],
                field(default=default if is_flag else _text(default)),
            )
        )
    for key, (metavar, text) in PLACES.items():
        about = tyro.conf.arg(name=key.replace("_", "-"), help=text, metavar=metavar)
        fields.append((key, Annotated[str, about], field(default="")))
    return make_dataclass(name, fields, frozen=True)


def _help(spec: Spec) -> str:
    if spec.key == "robot":
        return f"{spec.help} {', '.join(spec.choices)}, or a URDF file."
    if not spec.is_number or spec.low == -float("inf"):
        return spec.help
    unit = f" {spec.unit}" if spec.unit else ""
    return f"{spec.help} {spec.low:g} to {spec.high:g}{unit}."


def _metavar(spec: Spec, default: object) -> str:
    if spec.key == "robot":
        return "NAME|FILE"
    if spec.choices:
        return "{" + ",".join(spec.choices) + "}"
    if spec.read is not None:
        return "TEXT"
    return "INT" if isinstance(default, int) else "NUMBER"


def _text(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


RunOptions = _options(RunSettings, "RunOptions")
StartOptions = _options(
    RunSettings,
    "StartOptions",
    {
        "start": "where every joint of the room begins [rad, m], the left arm first: one line or one column of numbers, or one row "
        "below a header with the names of q's columns."
    },
)


def all_options() -> type:
    """Options of a page, which also tell `--no-world` from no word about it: then arms glide on a page that begins as usual."""
    options = _options(Settings, "AllOptions")
    about = tyro.conf.arg(
        name="no-world", help="Arms do not glide along, not even on a page that begins as usual."
    )
    one_way = tyro.conf.FlagCreatePairsOff
    fields: list[tuple[str, Any, Any]] = [
        ("world", one_way[options.__annotations__["world"]], field(default=False)),
        (NO_WORLD, one_way[Annotated[bool, about]], field(default=False)),
    ]
    return make_dataclass("AllOptions", fields, bases=(options,), frozen=True)


def glides_as_usual(options: object) -> bool:
    """False if `--no-world` is given: then arms glide nowhere. `options`: of `all_options`."""
    return not getattr(options, NO_WORLD, False)


def settings_of_options(options: object, start: Any) -> Any:
    """Settings of the options.

    Raises:
        BadSetting, BadInputFile: an option's value is not possible, or a robot's file cannot be used.
    """
    given = asdict(cast(Any, options))
    if given.pop(NO_WORLD, False) and given["world"]:
        raise BadSetting("--world and --no-world exclude each other; give one of them.")
    left, right, hand_left, hand_right, base_left, base_right = (given.pop(key) for key in PLACES)
    given["robot"] = _robot(given["robot"], (left, right), (hand_left, hand_right))
    if base_left or base_right:
        from scenes.rigs import place_bases

        given["rig"] = place_bases(base_left, base_right)
    for key, value in given.items():
        start = changed(start, key, value)
    if base_left or base_right or any(name not in get_args(RobotName) for name in makes(given["robot"])):
        from scenes.roles import room_of

        # Report what cannot be built now, not to the first visitor.
        room_of(start.run if isinstance(start, Settings) else start)
        _say_guesses(given["robot"])
    return start


def _robot(both: str, sides: tuple[str, str], hands: tuple[str, str]) -> str:
    """Value of the setting `robot`; files are read and become possible values.

    Args:
        sides: options of the left and of the right arm, or "".
        hands: names of their hands' links, or "".

    Raises:
        BadSetting: a hand is named for an arm that is not from a file.
        BadInputFile: a file cannot be used.
    """
    usual = (both, both) if _is_file(both) else makes(both)
    made: list[str] = []
    for side, text, hand in zip(
        ("left", "right"), (sides[0] or usual[0], sides[1] or usual[1]), hands, strict=True
    ):
        if _is_file(text):
            text = robot_from_file(Path(text), hand)
        elif hand:
            raise BadSetting(
                f"hand-{side} = {hand!r}: the hand of the arm {text} is known; "
                f"name a link of a URDF file that you give with --robot-{side}."
            )
        made.append(text)
    return made[0] if made[0] == made[1] else PAIR.join(made)


def _say_guesses(robot: str) -> None:
    for line in dict.fromkeys(GIVEN[name].remark for name in makes(robot) if name in GIVEN):
        print(line, file=sys.stderr)


def _is_file(text: str) -> bool:
    return reads_robots() and (
        "/" in text or "\\" in text or text.lower().endswith((".urdf", ".xacro", ".xml"))
    )


Flat = tyro.conf.OmitArgPrefixes


def shown_alone(options: type, names: Collection[str]) -> type:
    """Dataclass of options with a help that shows only these fields.

    Raises:
        ValueError: it has no field of one of the names.
    """
    every = {one.name: one for one in fields(options)}
    if unknown := set(names) - set(every):
        raise ValueError(f"{options.__name__} has no option {', '.join(sorted(unknown))}")
    hidden: list[tuple[str, Any, Any]] = [
        (name, tyro.conf.Suppress[one.type], field(default=one.default, default_factory=one.default_factory))  # type: ignore[misc]
        for name, one in every.items()
        if name not in names
    ]
    return make_dataclass(
        options.__name__, hidden, bases=(options,), frozen=True, namespace={"__doc__": options.__doc__}
    )


def in_one_list(options: type) -> Any:
    """Type of a command's field: its options are in the list of the command's own."""
    return Annotated[options, tyro.conf.arg(name="")]
