"""The robots, the experiments and their simulation; knows the controllers and no page. The names in `_PUBLIC`
are for notebooks.
"""

from typing import Final

from controllers import loaded_on_demand

_PUBLIC: Final = {
    "RunSettings": "settings",
    "LawSettings": "settings",
    "changed": "settings",
    "values": "settings",
    "run": "headless",
    "Run": "headless",
    "Summary": "headless",
    "Simulation": "simulation",
    "COLUMN": "history",
    "room_of": "roles",
    "read_grid": "sweep",
    "run_points": "sweep",
}

__getattr__ = loaded_on_demand(__name__, _PUBLIC)


def __dir__() -> list[str]:
    return sorted({*globals(), *_PUBLIC})
