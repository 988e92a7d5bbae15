"""Finds our packages before others of the same names, also in the Python processes that we start.

Many programs have packages named `app`, `controllers` or `scenes`. A new process must import the same files
as this one, so it runs this file as a script, which calls `main()` of the named module:

    python -P …/controllers/own_packages.py MODULE ARGUMENTS

`-P` keeps the current folder off the path, where a `random.py` would replace the standard library's. Imports
only fast parts of the standard library.
"""

import os
import sys
from collections.abc import Sequence
from importlib import import_module
from importlib.machinery import ModuleSpec, PathFinder
from types import ModuleType
from typing import Final

FOLDER: Final = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))

PACKAGES: Final = ("app", "controllers", "scenes")


class OwnPackages:
    @staticmethod
    def find_spec(
        name: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        return PathFinder.find_spec(name, [FOLDER]) if path is None and name in PACKAGES else None


def find_own_packages() -> None:
    """Find our packages before others of their names, unless those are loaded. Can be called again."""
    if not any(getattr(finder, "__qualname__", "") == OwnPackages.__qualname__ for finder in sys.meta_path):
        sys.meta_path.insert(0, OwnPackages)


def refuse_other_packages() -> None:
    """Raise ImportError if another program's module has one of our names."""
    for name in PACKAGES:
        loaded = sys.modules.get(name)
        folders = [os.path.realpath(folder) for folder in getattr(loaded, "__path__", ())]
        if loaded is not None and os.path.realpath(os.path.join(FOLDER, name)) not in folders:
            other = getattr(loaded, "__file__", None) or loaded
            raise ImportError(
                f"Duet needs the name {name!r}, which this Python has given to {other}. Restart the kernel, or the program, and import "
                "lwr_duet first; or rename that file."
            )


def own_command(module: str, *arguments: str) -> list[str]:
    """Command that runs `main()` of our module in a new Python process."""
    return [sys.executable, "-P", os.path.join(FOLDER, "controllers", "own_packages.py"), module, *arguments]


# As a script, and in a worker of `multiprocessing` (see `scenes.children`); a program that imports it has found them.
if __name__ != "controllers.own_packages":
    find_own_packages()

if __name__ == "__main__":
    # The arguments are those of the module, as with `python -m`.
    del sys.argv[0]
    sys.exit(import_module(sys.argv[0]).main())
