"""Missing shared libraries of the system, and how to install them."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

from controllers.errors import DuetError

PACKAGES: Final = {
    "libatomic.so.1": "libatomic1",
    "libEGL.so.1": "libegl1",
    "libGL.so.1": "libgl1",
    "libGLESv2.so.2": "libgles2",
    "libglib-2.0.so.0": "libglib2.0-0",
    "libgomp.so.1": "libgomp1",
    "libgthread-2.0.so.0": "libglib2.0-0",
    "libstdc++.so.6": "libstdc++6",
    "libz.so.1": "zlib1g",
}
"""Needed library → package of Debian and Ubuntu."""

# A library with a path is a package's own, which no package of the system has.
_MISSING: Final = re.compile(r"(?<![\w./+-])([\w.+-]+\.so(?:\.\d+)*): cannot open shared object file")

_INSTALLED: Final = re.compile(r".*(?:site|dist)-packages/(\w+)")
"""Path of a module → its top-level package."""


class MissingLibrary(DuetError):
    """A shared library of the system is missing; the message names its user and how to install it."""

    def __init__(self, message: str, library: str = "") -> None:
        super().__init__(message)
        self.library = library


def missing_library(text: str) -> str | None:
    """Shared library that the system's loader did not find; None for other errors."""
    found = _MISSING.search(text)
    return found[1] if found else None


def remedy(library: str, needed_by: str) -> str:
    lack = f"{needed_by} needs the system's library {library}, which is missing"
    if library in PACKAGES:
        return f"{lack}: as root, on Debian or Ubuntu, apt install {PACKAGES[library]}."
    return (
        f"{lack}: install the package that has it; `apt-file search {library}` names it on Debian and Ubuntu, "
        f"`dnf provides '*/{library}'` on Fedora."
    )


@contextmanager
def naming_missing_library() -> Iterator[None]:
    """Raise `MissingLibrary` instead of an ImportError or OSError that a missing shared library causes."""
    try:
        yield
    except (ImportError, OSError) as error:
        library = missing_library(str(error)) or missing_library(str(error.__cause__))
        if library is None:
            raise
        raise MissingLibrary(remedy(library, _package(error)), library) from None


def _package(error: ImportError | OSError) -> str:
    if not isinstance(error, ImportError):
        return "Python"
    found = _INSTALLED.match(error.path or "")
    return found[1] if found else (error.name or "Python").partition(".")[0]
