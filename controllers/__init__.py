"""The mathematics of one tick with numpy, Pinocchio and coal.

`controllers.laws.situation` has the inputs of a law with symbols and units. `_PUBLIC` is for notebooks: `from
controllers import resting_distance`.
"""

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any, Final

_PUBLIC: Final = {
    "Arm": "kinematics",
    "Kinematics": "kinematics",
    "damped_solution": "kinematics",
    "null_space_projector": "kinematics",
    "ProximityDetector": "proximity",
    "resting_distance": "budget",
    "largest_step": "budget",
    "Situation": "laws.situation",
    "SmoothPriority": "laws.smooth_priority",
    "BadSetting": "errors",
}


def loaded_on_demand(package: str, names: Mapping[str, str]) -> Callable[[str], Any]:
    """A package's `__getattr__` that loads a name's module at its first use: settings alone load no robot."""

    def load(name: str) -> Any:
        if name not in names:
            raise AttributeError(f"{package} has no {name!r}; it has {', '.join(names)}")
        return getattr(import_module(f"{package}.{names[name]}"), name)

    return load


__getattr__ = loaded_on_demand(__name__, _PUBLIC)


def __dir__() -> list[str]:
    return sorted({*globals(), *_PUBLIC})
