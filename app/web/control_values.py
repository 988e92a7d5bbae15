"""One control as far as a browser may change it, and which values it may take."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import msgspec

from app.web.schemas import Field, Refused, number, row, text
from app.web.traffic_limits import TrafficLimits

Scope = Literal["own", "shared"]


@dataclass(frozen=True)
class Control:
    """One GUI element as far as a browser may change it.

    Attributes:
        scope: "own" if only this browser has it, "shared" if all browsers see the same one.
        value: its present value; a new one must be of the same kind.
        enabled: False while it is greyed out.
        low, high: bounds, a number for all components or one for each; None for none.
        options: the allowed texts; None for any.
        takes_files: an upload button.
    """

    scope: Scope
    value: object
    enabled: bool = True
    low: float | Sequence[float] | None = None
    high: float | Sequence[float] | None = None
    options: Collection[str] | None = None
    takes_files: bool = False


def _bound(bounds: object, index: int) -> float | None:
    bound = bounds[index] if isinstance(bounds, (list, tuple)) else bounds
    return float(bound) if isinstance(bound, (int, float)) else None


def check_value(control: Control, sent: msgspec.Raw, limits: TrafficLimits) -> None:
    """Check that `control` may take a value; raises `Malformed` or `Refused`."""
    present = control.value
    if isinstance(present, bool):
        Field(bool).read(sent)
    elif isinstance(present, str):
        value = text(limits.text_bytes).read(sent)
        if control.options is not None and value not in control.options:
            raise Refused("not one of the options")
    elif isinstance(present, (int, float, tuple)):
        entries: Any = row(len(present), number()).read(sent) if isinstance(present, tuple) else (number().read(sent),)
        for index, entry in enumerate(entries):
            low, high = _bound(control.low, index), _bound(control.high, index)
            # The browser computes min + k step in its own rounding.
            slack = 1e-6 * max(1e-3, abs(low or 0.0), abs(high or 0.0))
            if (low is not None and entry < low - slack) or (high is not None and entry > high + slack):
                raise Refused("number out of range")
    else:
        raise Refused("element without a value")
