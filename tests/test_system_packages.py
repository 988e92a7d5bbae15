"""The tests install a missing system library, or report in one sentence that they cannot."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from controllers.system_libraries import MissingLibrary, remedy
from tests.system_packages import with_libraries
from tests.test_imports import ROOT


class Machine:
    """Libraries of a machine.

    Args:
        lacks: missing libraries, in the loader's order.
        helps: True if packages can be installed.
    """

    def __init__(self, *lacks: str, helps: bool = True) -> None:
        self._lacks, self._helps = list(lacks), helps
        self.installed: list[str] = []

    def start(self) -> None:
        if self._lacks:
            raise MissingLibrary(remedy(self._lacks[0], "node"), self._lacks[0])

    def install(self, package: str) -> None:
        self.installed.append(package)
        if self._helps:
            del self._lacks[0]


def test_every_missing_library_is_installed() -> None:
    machine = Machine("libatomic.so.1", "libgomp.so.1")
    with_libraries(machine.start, machine.install)
    assert machine.installed == ["libatomic1", "libgomp1"]


@pytest.mark.parametrize(
    ("machine", "asked"),
    [(Machine("libatomic.so.1", helps=False), ["libatomic1"]), (Machine("libunknown.so.3"), [])],
    ids=["no root", "no known package"],
)
def test_a_library_that_cannot_be_installed_is_reported(machine: Machine, asked: list[str]) -> None:
    with pytest.raises(MissingLibrary, match=r"node needs the system's library lib\w+\.so"):
        with_libraries(machine.start, machine.install)
    assert machine.installed == asked


@pytest.mark.slow
def test_an_unavailable_library_ends_all_tests_with_one_sentence(tmp_path: Path) -> None:
    (tmp_path / "pinocchio").mkdir()
    (tmp_path / "pinocchio" / "__init__.py").write_text(
        "raise ImportError('libunknown.so.3: cannot open shared object file: No such file', name=__name__)\n",
        encoding="utf-8",
    )
    command = [sys.executable, "-m", "pytest", "-n", "0", "tests/test_names.py"]
    environment = os.environ | {"PYTHONPATH": str(tmp_path)}
    done = subprocess.run(
        command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode != 0
    assert done.stderr == f"The tests cannot run: {remedy('libunknown.so.3', 'pinocchio')}\n"
