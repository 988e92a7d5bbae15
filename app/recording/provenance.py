"""Provenance of a run: program, libraries and machine, on which its last bits may depend."""

import importlib.metadata
import platform
from typing import Final

import numpy as np
import pinocchio as pin

from controllers.errors import LazyText

LONGEST: Final = 40
"""Characters of one entry at most."""

NAMES: Final[dict[str, str]] = {
    "duet": "Duet",
    "python": "Python",
    "numpy": "numpy",
    "pinocchio": "Pinocchio",
    "system": LazyText("system"),
    "machine": LazyText("processor"),
}
"""Key → what a person calls it."""

_UNKNOWN: Final = LazyText("unknown")


def made_here() -> dict[str, str]:
    """Return key of `NAMES` → version or name, of this very program."""
    try:
        duet = importlib.metadata.version("lwr-duet")
    except importlib.metadata.PackageNotFoundError:
        duet = "0"
    return {
        "duet": duet,
        "python": platform.python_version(),
        "numpy": np.__version__,
        "pinocchio": str(pin.__version__),
        "system": platform.system(),
        "machine": platform.machine(),
    }


def made_from(data: object) -> dict[str, str]:
    """Return the provenance that a file states, unknown entries left out; never raises."""
    if not isinstance(data, dict):
        return {}
    return {key: str(data[key])[:LONGEST] for key in NAMES if isinstance(data.get(key), str)}


def unlike(then: dict[str, str], now: dict[str, str]) -> tuple[LazyText, ...]:
    """Return "numpy 2.3.1 then, 2.4.0 now" for everything that is not the same."""
    return tuple(
        LazyText("{name} {then} then, {now} now", name=name, then=then.get(key, _UNKNOWN), now=now.get(key, _UNKNOWN))
        for key, name in NAMES.items()
        if then.get(key) != now.get(key)
    )
