"""System packages that the tests install if they can: as root on Debian or Ubuntu."""

import os
import shutil
import subprocess
from collections.abc import Callable, Sequence

from controllers.system_libraries import PACKAGES, MissingLibrary, naming_missing_library


def run(command: Sequence[str]) -> str:
    """Run a command. Returns its error, or ""."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)
    except (OSError, subprocess.TimeoutExpired) as error:
        return f"{' '.join(command)}: {error}"
    return (
        "" if done.returncode == 0 else f"{' '.join(command)}: {(done.stderr or done.stdout).strip()[-300:]}"
    )


def install_package(name: str) -> list[str]:
    """Install a system package if possible, as root on Debian. Returns the errors."""
    if not hasattr(os, "geteuid") or os.geteuid() != 0 or shutil.which("apt-get") is None:
        return []
    install = ["apt-get", "install", "-y", "--no-install-recommends", name]
    return [problem for command in (["apt-get", "update"], install) if (problem := run(command))]


def with_libraries(attempt: Callable[[], object], install: Callable[[str], object] = install_package) -> None:
    """Repeat `attempt` after the installation of each missing library's package.

    Args:
        attempt: raises `MissingLibrary`.
        install: takes the name of a package.

    Raises:
        MissingLibrary: its package is unknown, or did not help.
    """
    tried: set[str] = set()
    while True:
        try:
            attempt()
            return
        except MissingLibrary as error:
            if error.library in tried or error.library not in PACKAGES:
                raise
            tried.add(error.library)
            install(PACKAGES[error.library])


def import_pinocchio() -> None:
    """Import modules with libraries that a slim system lacks.

    Raises:
        MissingLibrary: a library is missing.
    """
    with naming_missing_library():
        import coal  # noqa: F401
        import pinocchio  # noqa: F401
