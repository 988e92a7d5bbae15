"""Find our own top-level packages, whatever else of that name is on the path; and start Python processes that do the same.

Their names (`app`, `controllers`, `scenes`) are those of many other programs. A process that we start must import the very same
files as this one, in any folder, from a wheel, an editable install or a checkout. So it is started by this file, as a script:

    python -P …/controllers/own_packages.py MODULE ARGUMENTS

`-P` keeps the current folder off the path, where a `random.py` would take the place of the standard library's. Then it calls `main()`
of the module that is named. `lwr_duet` uses the same finder in a notebook. Imports nothing of ours, and nothing slow.
"""

import os
import sys
from collections.abc import Sequence
from importlib import import_module
from importlib.machinery import ModuleSpec, PathFinder
from types import ModuleType
from typing import Final

FOLDER: Final = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
"""Folder that holds our packages."""

PACKAGES: Final = ("app", "controllers", "scenes")
"""Names of our top-level packages."""


class OwnPackages:
    """Finder of `sys.meta_path` for our top-level packages alone."""

    @staticmethod
    def find_spec(name: str, path: Sequence[str] | None = None, target: ModuleType | None = None) -> ModuleSpec | None:
        return PathFinder.find_spec(name, [FOLDER]) if path is None and name in PACKAGES else None


def find_own_packages() -> None:
    """Let this process find our packages before all others of their names, unless those are loaded. Can be called again."""
    if not any(getattr(finder, "__qualname__", "") == OwnPackages.__qualname__ for finder in sys.meta_path):
        sys.meta_path.insert(0, OwnPackages)


def refuse_other_packages() -> None:
    """Check that no other program's package or module has one of our names.

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
    """Command that runs `main()` of a module of ours in a Python of its own, whatever the current folder is."""
    return [sys.executable, "-P", os.path.join(FOLDER, "controllers", "own_packages.py"), module, *arguments]


# As a script, and in a worker of `multiprocessing` (see `scenes.children`); a program that imports it has found them.
if __name__ != "controllers.own_packages":
    find_own_packages()

if __name__ == "__main__":
    # The arguments are those of the module, as with `python -m`.
    del sys.argv[0]
    sys.exit(import_module(sys.argv[0]).main())
