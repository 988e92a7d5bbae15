"""Every setting of a tree as an option of a command."""

from dataclasses import asdict, field, make_dataclass
from typing import Annotated, Any, cast

import tyro

from app.settings import Settings
from scenes.settings import RunSettings, Spec, changed, specs, values


def _options(tree: type, name: str) -> type:
    """Return a dataclass with a text option for every setting of a tree: a bad text gets the line that names the choices, as in a link."""
    fields: list[tuple[str, Any, Any]] = []
    for key, spec in specs(tree).items():
        default = values(tree())[key]
        about = tyro.conf.arg(name=key.replace("_", "-"), help=_help(spec), metavar=_metavar(spec, default))
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
