"""All commands and their processes import the project's and Python's files, not the current folder's."""

import ast
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from app.runtime.terminal import TERMINATED
from controllers.own_packages import FOLDER, own_command
from tests.app.runtime.processes import until
from tests.app.served import is_whole
from tests.blocking_client import BlockingClient
from tests.test_imports import ROOT

pytestmark = pytest.mark.slow

OURS = ("app", "controllers", "scenes")
LIBRARY = (
    "random",
    "types",
    "socket",
    "json",
    "logging",
    "queue",
    "struct",
    "tempfile",
    "selectors",
    "typing",
    "signal",
    "numpy",
)

PATIENCE = 240.0


@pytest.fixture
def strange(tmp_path: Path) -> Path:
    """Folder with files of these names, each of which records its import and fails."""
    folder = tmp_path / "work"
    folder.mkdir()
    for name in (*OURS, *LIBRARY):
        text = f"open({str(tmp_path / 'imported')!r}, 'a').write({name!r} + ' ')\nraise SystemExit('the wrong file')\n"
        (folder / f"{name}.py").write_text(text, encoding="utf-8")
    return folder


@pytest.fixture
def program(tmp_path: Path) -> list[str]:
    """The installed command as pip writes it: Python searches its folder, not the current one."""
    script = tmp_path / "bin" / "lwr-duet"
    script.parent.mkdir()
    script.write_text(
        "import sys\nfrom app.__main__ import entry\nif __name__ == '__main__':\n    sys.exit(entry())\n",
        encoding="utf-8",
    )
    return [sys.executable, str(script)]


def imported(folder: Path) -> str:
    """Names of the folder's imported files."""
    said = folder.parent / "imported"
    return said.read_text(encoding="utf-8") if said.exists() else ""


ENVIRONMENT = {key: value for key, value in os.environ.items() if key not in ("PYTHONPATH", "PYTHONSAFEPATH")}


@contextmanager
def served(command: list[str], folder: Path) -> Iterator[str]:
    with (
        (folder.parent / "said").open("w+") as said,
        subprocess.Popen(
            command, cwd=folder, env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=said, text=True
        ) as server,
    ):
        try:
            assert server.stdout is not None
            words = server.stdout.readline().split()
            assert words[:3] == ["Duet", "is", "at"], (
                words,
                (folder.parent / "said").read_text(encoding="utf-8"),
            )
            yield words[3]
            server.send_signal(signal.SIGTERM)
            assert server.wait(60.0) == TERMINATED
        finally:
            server.kill()


@pytest.mark.parametrize("workers", ["1", pytest.param("2", marks=pytest.mark.thorough)])
def test_serve_shows_the_arms_and_computes_in_the_background(
    strange: Path, program: list[str], workers: str
) -> None:
    options = ["serve", "--no-open", "--port", "0", "--store", "memory", "--workers", workers]
    with (
        served([*program, *options], strange) as url,
        BlockingClient(url, query="whatif=1&seed=3") as visitor,
    ):
        visitor.wait_for(is_whole)
        # "What if" is a job of the worker processes.
        until(lambda: imported(strange) or computing(strange))
    assert imported(strange) == ""


def computing(folder: Path) -> bool:
    """True if a `multiprocessing` worker in this folder has loaded the robots' library."""
    for process in Path("/proc").glob("[0-9]*"):
        try:
            if (
                os.readlink(process / "cwd") == str(folder)
                and b"spawn_main" in (process / "cmdline").read_bytes()
            ):
                return "pinocchio" in (process / "maps").read_text(encoding="utf-8")
        except OSError:
            continue
    return False


COMMANDS = {
    "run": ["run", "--seconds", "0.05"],
    "sweep": ["sweep", "--over", "n=4,6,8,10", "--seconds", "0.05", "--workers", "2", "--no-maps"],
    "bench": ["bench", "--steps", "1", "--seconds", "0.2"],
    "law-test": ["law-test", "my_law.py"],
}


@pytest.mark.parametrize(
    "name", ["run", *(pytest.param(name, marks=pytest.mark.thorough) for name in COMMANDS if name != "run")]
)
def test_a_command_imports_no_file_of_the_current_folder(
    strange: Path, program: list[str], name: str
) -> None:
    if name == "law-test":
        subprocess.run(
            [*program, "new-law", "my_law.py"], cwd=strange, env=ENVIRONMENT, timeout=PATIENCE, check=True
        )
    done = subprocess.run(
        [*program, *COMMANDS[name]],
        cwd=strange,
        env=ENVIRONMENT,
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )
    assert imported(strange) == ""
    if name == "law-test":
        # On a busy machine the law may fail a test, but the command runs.
        assert "my_law.py: " in done.stdout and "keeps" in done.stdout, done.stderr[-3000:]
    else:
        assert done.returncode == 0 and done.stdout, done.stderr[-3000:]


def test_a_child_process_finds_the_same_packages(strange: Path) -> None:
    """Also if PYTHONPATH leads to another `app`, for example by a trailing colon."""
    shown = subprocess.run(
        own_command("app.__main__", "run", "--help"),
        cwd=strange,
        env=ENVIRONMENT | {"PYTHONPATH": os.pathsep.join(["", str(strange / "elsewhere")])},
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )
    assert Path(FOLDER) == ROOT
    # Python itself imports the library's names by PYTHONPATH, but the project's must not be among them.
    assert not set(imported(strange).split()) & set(OURS), shown.stderr


STUDY = """
import app
from scenes.children import computed

if __name__ == "__main__":
    print(sorted(computed(app.double, [(1,), (2,)], 2)))
"""


@pytest.mark.thorough
def test_a_program_with_its_own_app_module_computes_on_several_cores(tmp_path: Path) -> None:
    (tmp_path / "app.py").write_text("def double(x):\n    return 2 * x\n", encoding="utf-8")
    (tmp_path / "study.py").write_text(STUDY, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "study.py"],
        cwd=tmp_path,
        env=ENVIRONMENT,
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )
    assert done.stdout == "[(0, 2), (1, 4)]\n", done.stderr[-3000:]


STARTERS = ("controllers/own_packages.py", "app/features/jupyter/tile.py")
"""Files that may choose a process's program: the common one, and the tile, without project imports."""


def starts_python(source: str) -> bool:
    """True if a program starts Python without `own_command` or `scenes.children.SPAWN`."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            if (node.value.id, node.attr) == ("sys", "executable"):
                return True
            if node.value.id == "multiprocessing" and node.attr in (
                "get_context",
                "Process",
                "Pool",
                "Manager",
            ):
                return True
    return False


def test_no_other_file_starts_python() -> None:
    assert starts_python("import sys, subprocess\nsubprocess.run([sys.executable, '-m', 'app'])")
    assert starts_python("import multiprocessing\nmultiprocessing.get_context('spawn')")
    files = {
        path.relative_to(ROOT).as_posix(): path for floor in OURS for path in (ROOT / floor).rglob("*.py")
    }
    found = {name for name, path in files.items() if starts_python(path.read_text(encoding="utf-8"))}
    # `fence.py` only reads the folders of Python.
    assert found == {*STARTERS, "app/features/marks/fence.py"} & files.keys()
