"""Finds our top-level packages before others of their names, and starts Python processes that do the same.

Many programs have packages named `app`, `controllers` or `scenes`. A new process must import the same files
as this one, in any folder, from a wheel, an editable install or a checkout. So it runs this file as a script:

    python -P …/controllers/own_packages.py MODULE ARGUMENTS

`-P` keeps the current folder off the path, where a `random.py` would replace the standard library's. Then it
calls `main()` of the named module. `lwr_duet` uses the same finder in a notebook. Imports only fast parts of
the standard library.
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
    """Find our packages before all others of their names, unless those are loaded. Can be called again."""
    if not any(getattr(finder, "__qualname__", "") == OwnPackages.__qualname__ for finder in sys.meta_path):
        sys.meta_path.insert(0, OwnPackages)


def refuse_other_packages() -> None:
    """Raise an error if another program's module has one of our names.

    Raises:
        ImportError: one is loaded already.
    """
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
    """Command that runs `main()` of one of our modules in a new Python process, from any current folder."""
    return [sys.executable, "-P", os.path.join(FOLDER, "controllers", "own_packages.py"), module, *arguments]


# As a script, and in a worker of `multiprocessing` (see `scenes.children`); a program that imports it has found them.
if __name__ != "controllers.own_packages":
    find_own_packages()

if __name__ == "__main__":
    # The arguments are those of the module, as with `python -m`.
    del sys.argv[0]
    sys.exit(import_module(sys.argv[0]).main())
