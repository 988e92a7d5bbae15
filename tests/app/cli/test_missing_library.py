"""Every command reports a missing system library in one sentence, also if only a worker needs it."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from controllers.system_libraries import remedy
from tests.test_imports import ROOT

ALONE = ("--no-open", "--port", "0", "--store", "memory", "--workers", "1")
COMMANDS: dict[str, tuple[str, ...]] = {
    "the page": ALONE,
    "the page in workers": ("serve", *ALONE[:-1], "2"),
    "run": ("run", "--seconds", "0.1"),
    "bench": ("bench",),
    "figures": ("figures",),
    "hunt": ("hunt",),
    "league": ("league",),
    "robots": ("robots",),
    "lessons": ("lessons",),
    "grade": ("grade", "."),
}


@pytest.fixture
def slim(tmp_path: Path) -> dict[str, str]:
    """Environment in which pinocchio fails as on a system without libgomp1."""
    (tmp_path / "pinocchio").mkdir()
    (tmp_path / "pinocchio" / "__init__.py").write_text(
        "raise ImportError('libgomp.so.1: cannot open shared object file: No such file or directory', name=__name__)\n",
        encoding="utf-8",
    )
    return os.environ | {"PYTHONPATH": str(tmp_path)}


@pytest.mark.slow
@pytest.mark.parametrize("arguments", COMMANDS.values(), ids=COMMANDS)
def test_a_command_reports_the_missing_library_and_ends(
    arguments: tuple[str, ...], slim: dict[str, str]
) -> None:
    command = [sys.executable, "-m", "app", *arguments]
    done = subprocess.run(
        command, cwd=ROOT, env=slim, capture_output=True, text=True, timeout=120, check=False
    )
    assert done.stderr == f"lwr-duet: {remedy('libgomp.so.1', 'pinocchio')}\n"
    assert (done.returncode, done.stdout) == (2, "")
