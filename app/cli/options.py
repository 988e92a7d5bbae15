"""Every setting of a tree as an option of a command."""

from collections.abc import Mapping
from dataclasses import asdict, field, make_dataclass
from types import MappingProxyType
from typing import Annotated, Any, cast

import tyro

from app.settings import Settings
from scenes.settings import RunSettings, Spec, changed, specs, values


def _options(tree: type, name: str, files: Mapping[str, str] = MappingProxyType({})) -> type:
    """Return a dataclass with a text option for every setting of a tree: a bad text gets the line that names the choices, as in a link.

    Args:
        files: key of a setting that may be a file instead → what it holds.
    """
    fields: list[tuple[str, Any, Any]] = []
    for key, spec in specs(tree).items():
        default = values(tree())[key]
        text, metavar = _help(spec), _metavar(spec, default)
        if key in files:
            text, metavar = f"{text} Or a file: {files[key]}", f"{metavar}|FILE"
        about = tyro.conf.arg(name=key.replace("_", "-"), help=text, metavar=metavar)
        kind: Any = bool if isinstance(default, bool) else str
        fields.append((key, Annotated[kind, about], field(default=default if isinstance(default, bool) else _text(default))))
    return make_dataclass(name, fields, frozen=True)


def _help(spec: Spec) -> str:
    if spec.choices or spec.low == -float("inf"):
        return spec.help
    unit = f" {spec.unit}" if spec.unit else ""
    return f"{spec.help} {spec.low:g} to {spec.high:g}{unit}."


def _metavar(spec: Spec, default: object) -> str:
    if spec.choices:
        return "{" + ",".join(spec.choices) + "}"
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
AllOptions = _options(Settings, "AllOptions")


def chosen(options: object, start: Any) -> Any:
    """Return the settings that the options ask for.

    Raises:
        BadSetting: an option's value is not possible.
    """
    for key, value in asdict(cast(Any, options)).items():
        start = changed(start, key, value)
    return start


Flat = tyro.conf.OmitArgPrefixes
"""Type of a command's field: its options have no prefix."""
