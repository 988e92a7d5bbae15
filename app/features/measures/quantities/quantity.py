"""Measurable quantities, and texts of values."""

import inspect
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import wraps
from typing import Any, Final, Literal, NamedTuple, get_args, get_origin

from app.features.measures.evidence import Evidence
from controllers.errors import BadSetting, NumberText
from controllers.kinematics import Array

Value = float | None
"""In SI units; None if the run does not tell (yet)."""

Row = int | None
"""Row of `Evidence.table`."""


class At(NamedTuple):
    """A value and its row of `Evidence.table`."""

    value: float
    row: int


def at(values: Array, row: Row) -> At | None:
    """`values[row]` with its row, or None."""
    return None if row is None else At(float(values[row]), row)


Reading = At | Value
"""A value alone has no single moment; nan counts as None."""


class Unit(NamedTuple):
    """SI unit, factor from it, and suffix of a number for readers."""

    si: str
    factor: float
    sign: str


UNITS: Final[dict[str, Unit]] = {
    "": Unit("", 1.0, ""),
    "%": Unit("", 100.0, "%"),
    "m": Unit("m", 1.0, "m"),
    "cm": Unit("m", 100.0, "cm"),
    "mm": Unit("m", 1000.0, "mm"),
    "rad": Unit("rad", 1.0, "rad"),
    "deg": Unit("rad", 180.0 / math.pi, "°"),
    "m/s": Unit("m/s", 1.0, "m/s"),
    "mm/s": Unit("m/s", 1000.0, "mm/s"),
    "rad/s": Unit("rad/s", 1.0, "rad/s"),
    "deg/s": Unit("rad/s", 180.0 / math.pi, "°/s"),
    "s": Unit("s", 1.0, "s"),
    "ms": Unit("s", 1000.0, "ms"),
    "1/s": Unit("1/s", 1.0, "1/s"),
    "m/rad": Unit("m/rad", 1.0, "m/rad"),
}
"""Name in lesson files → unit."""


@dataclass(frozen=True)
class Quantity:
    """A measurable quantity.

    Attributes:
        label: for readers, perhaps with parameters in braces.
        shown: usual unit, see `UNITS`.
        digits: after the point, in that unit.
        live: True if it needs only the newest step.
        function: (evidence, **parameters) → Reading.
    """

    label: str
    shown: str
    digits: int
    live: bool
    function: Callable[..., Reading]

    @property
    def parameters(self) -> dict[str, inspect.Parameter]:
        return dict(list(inspect.signature(self.function).parameters.items())[1:])

    @property
    def units(self) -> tuple[str, ...]:
        return tuple(name for name, unit in UNITS.items() if unit.si == UNITS[self.shown].si)


QUANTITIES: Final[dict[str, Quantity]] = {}
"""Filled by the other modules."""


def quantity(
    label: str,
    shown: str,
    digits: int,
    live: bool = False,
    obstacle: bool = False,
    settings: bool = False,
) -> Callable[[Callable[..., Reading]], Callable[..., Reading]]:
    """Register a function of `Evidence` as a quantity.

    Args:
        obstacle: True if it needs an obstacle.
        settings: True if it needs only the settings, even before the first step.
    """

    def note(measured: Callable[..., Reading]) -> Callable[..., Reading]:
        @wraps(measured)
        def function(evidence: Evidence, **parameters: Any) -> Reading:
            told = settings or (evidence.has_obstacle if obstacle else evidence.rows > 0)
            return measured(evidence, **parameters) if told else None

        QUANTITIES[function.__name__] = Quantity(label, shown, digits, live, function)
        return function

    return note


def read_parameters(
    what: str, wanted: Mapping[str, inspect.Parameter], given: Mapping[str, Any]
) -> tuple[tuple[str, Any], ...]:
    """Checked keyword arguments.

    Raises:
        BadSetting: unknown or missing parameter, or impossible value.
    """
    for key in given:
        if key not in wanted:
            remedy = f"choose from {', '.join(wanted)}" if wanted else "remove it, there are none"
            raise BadSetting(f"{what} has no parameter {key!r}; {remedy}.")
    found: list[tuple[str, Any]] = []
    for key, parameter in wanted.items():
        if key not in given:
            if parameter.default is inspect.Parameter.empty:
                raise BadSetting(f"{what} needs the parameter {key!r}.")
            continue
        found.append((key, _read(f"{what}: {key}", parameter.annotation, given[key])))
    return tuple(found)


def _read(what: str, kind: Any, value: object) -> Any:
    if get_origin(kind) is Literal:
        if value in get_args(kind):
            return value
        raise BadSetting(f"{what} = {value!r:.40} is not possible; choose from {', '.join(get_args(kind))}.")
    if kind is str:
        if isinstance(value, str):
            return value
        raise BadSetting(f"{what} = {value!r:.40} is not a text.")
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise BadSetting(f"{what} = {value!r:.40} is not a number.")
    if abs(value) > 1e6:
        raise BadSetting(f"{what} = {value:g} is too large; SI units are meant.")
    return float(value)


def measure(evidence: Evidence, name: str, parameters: tuple[tuple[str, Any], ...] = ()) -> Value:
    """None if the run does not tell."""
    found = QUANTITIES[name].function(evidence, **dict(parameters))
    value = found.value if isinstance(found, At) else found
    return None if value is None or math.isnan(value) else float(value)


def moment(evidence: Evidence, name: str, parameters: tuple[tuple[str, Any], ...] = ()) -> float | None:
    """Time of the value [s]; None if it has no single moment."""
    found = QUANTITIES[name].function(evidence, **dict(parameters))
    if not isinstance(found, At) or math.isnan(found.value):
        return None
    return float(evidence.times[found.row]) + evidence.settings.dt


def shown_value(value: Value, unit: str, digits: int) -> str:
    """ "88.2 mm"; "–" for None. `unit`: see `UNITS`."""
    if value is None:
        return "–"
    _, factor, sign = UNITS[unit]
    number = value * factor
    if math.isinf(number):
        text = "∞" if number > 0.0 else "−∞"
    else:
        text = f"{number:.{digits}f}"
        if not text.strip("-0."):
            text = text.lstrip("-")
        text = text.replace("-", "−")
    return NumberText(text + sign if sign in ("°", "%") else f"{text} {sign}".rstrip())


def significant_digits(value: Value, unit: str, digits: int) -> int:
    """Digits after the point for two significant ones, at most `digits` + 1."""
    if not digits or value is None or not math.isfinite(value) or value == 0.0:
        return digits
    exponent = int(f"{value * UNITS[unit].factor:.1e}".partition("e")[2])
    return min(max(1 - exponent, 0), digits + 1)


_SHOWN: Final = {
    "angle": "deg",
    "distance": "mm",
    "gap": "mm",
    "time": "s",
    "dead": "ms",
    "since": "s",
    "until": "s",
}


def shown_parameter(name: str, value: object) -> str:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return str(value)
    _, factor, sign = UNITS[_SHOWN.get(name, "")]
    text = f"{value * factor:.3g}".replace("-", "−")
    return NumberText(text + sign if sign == "°" else f"{text} {sign}".rstrip())
