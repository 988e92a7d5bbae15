"""Duet by a name that no other program has: `from lwr_duet import duet` in a notebook, `from lwr_duet import RunSettings, run` in a script.

Our packages are `app`, `controllers` and `scenes`, and so are files of many other programs: beside an `app.py`, a notebook's `import app`
is that file. Importing this package lets the process find ours first, for as long as it runs; see `controllers/own_packages.py`. The
wheel and an editable install have it as a package of its own, which pyproject.toml says.

Raises:
    ImportError: another `app`, `controllers` or `scenes` was imported before.
"""

import os
from importlib import import_module
from importlib.util import module_from_spec, spec_from_file_location
from typing import Any, Final


def _find_packages() -> None:
    """Run the file that finds our packages: by its name it can be imported only when they are found."""
    here = os.path.dirname(os.path.abspath(__file__))
    inside = os.path.join("controllers", "own_packages.py")
    # Beside this package in a wheel; in a checkout this one is in `app`.
    beside, above = (
        os.path.join(folder, inside)
        for folder in (os.path.dirname(here), os.path.dirname(os.path.dirname(here)))
    )
    spec = spec_from_file_location("controllers.own_packages", beside if os.path.isfile(beside) else above)
    assert spec is not None and spec.loader is not None
    own_packages = module_from_spec(spec)
    spec.loader.exec_module(own_packages)
    own_packages.refuse_other_packages()
    own_packages.find_own_packages()


_find_packages()

_PACKAGES: Final = ("scenes", "controllers")


def __getattr__(name: str) -> Any:
    """Load a public name when it is first used: `duet`, and all public names of `scenes` and `controllers`."""
    if name == "duet":
        return import_module("app.features.jupyter.duet")
    for package in map(import_module, _PACKAGES):
        if name in package._PUBLIC:
            return getattr(package, name)
    raise AttributeError(f"lwr_duet has no {name!r}; it has {', '.join(_public())}")


def _public() -> list[str]:
    return ["duet", *(name for package in map(import_module, _PACKAGES) for name in package._PUBLIC)]


def __dir__() -> list[str]:
    return sorted({*globals(), *_public()})
