"""Without one feature, and without all, the rest works: imports, help, a run, and a page that moves."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from app.features import FEATURES
from tests.test_imports import ROOT
from tests.test_rooms import arrows

pytestmark = pytest.mark.thorough

PATIENCE = 1200.0
NAMES = [feature.name for feature in FEATURES]
ALL = "all"

IMPORT_ALL = """
import importlib, pkgutil
import app, controllers, scenes
for package in (app, controllers, scenes):
    for module in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
        if module.name.endswith("__main__") or module.name.startswith("app.lwr_duet"):
            continue
        try:
            importlib.import_module(module.name)
        except ModuleNotFoundError as error:
            # What an extra installs may not be there.
            if (error.name or "").partition(".")[0] in ("app", "controllers", "scenes"):
                raise
"""

VISIT = """
from app.features import FEATURES
from app.hosting.serve_options import ServeOptions
from app.start import start_app
from tests.app.served import is_whole
from tests.blocking_client import BlockingClient

app = start_app(ServeOptions(sessions=2), features=FEATURES)
try:
    with BlockingClient(app.url, query="autopilot=1&seed=3") as visitor:
        visitor.wait_for(is_whole, 120.0)
        node = next(name for name in visitor.mirror.nodes if name.endswith("/right/base/j1"))
        first = visitor.mirror.nodes[node]["wxyz"]
        visitor.wait_for(lambda v: v.mirror.nodes[node]["wxyz"] != first, 120.0)
finally:
    app.close()
print("it moves")
"""


def _has_tests(folder: Path) -> bool:
    return folder.is_dir() and folder.name != "features" and any(folder.rglob("test_*.py"))


def _reaches_app(path: Path) -> bool:
    return re.search(r"^(?:from|import) app\b", path.read_text(encoding="utf-8"), re.MULTILINE) is not None


QUICK = (
    *sorted(f"app/{path.name}" for path in (ROOT / "tests" / "app").iterdir() if _has_tests(path)),
    *sorted(
        path.relative_to(ROOT / "tests").as_posix()
        for floor in ("controllers", "scenes")
        for path in (ROOT / "tests" / floor).rglob("*.py")
        if _reaches_app(path)
    ),
)
"""Folders and files with tests of the core, run one by one; all others below `app` cannot reach a feature."""


def users(of: str) -> set[str]:
    """Features that use a feature, directly or through others; they are removed with it."""
    folder = re.compile(r"app/features/([a-z_]+)/")
    above: dict[str, set[str]] = {name: set() for name in NAMES}
    for file, targets in arrows().items():
        if here := folder.match(file):
            for there in filter(None, map(folder.match, targets)):
                if there[1] != here[1]:
                    above[there[1]].add(here[1])
    found, todo = set[str](), [of]
    while todo:
        todo += [name for name in above[todo.pop()] - found if name not in {*found, of}]
        found |= set(todo)
    return found


def left_without(target: Path, gone: set[str]) -> None:
    """Copy the tree and remove features: folders, tests, and lines of the tuple.

    Args:
        target: folder of the copy; from an existing copy the features are only removed.
    """
    if not (target / "app").exists():
        copy_tree(target)
    take_out(target, gone)


def copy_tree(target: Path) -> None:
    """Copy all files that are under version control or would be."""
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    ).stdout.splitlines()
    for name in filter(lambda name: (ROOT / name).exists(), listed):
        (target / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / name, target / name)


def take_out(target: Path, gone: set[str]) -> None:
    """Delete the folders, the tests and the lines of features."""
    for name in gone:
        shutil.rmtree(target / "app" / "features" / name)
        shutil.rmtree(target / "tests" / "app" / "features" / name, ignore_errors=True)
    path = target / "app" / "features" / "__init__.py"
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    of = [re.compile(rf"from app\.features\.{name} import|^    {name.upper()},$") for name in gone]
    kept = [line for line in lines if not any(one.search(line) for one in of)]
    assert len(lines) - len(kept) == 2 * len(gone), "expected an import and an entry for each feature"
    path.write_text("".join(kept), encoding="utf-8")


def do(folder: Path, *command: str) -> str:
    """Output of a command in the copy. The command must succeed, and nothing comes from this tree."""
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"} | {
        "PYTHONPATH": str(folder)
    }
    done = subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, timeout=PATIENCE, check=False
    )
    assert done.returncode == 0, f"{command}\n{done.stdout[-3000:]}\n{done.stderr[-3000:]}"
    return done.stdout


@pytest.mark.timeout(PATIENCE)
@pytest.mark.parametrize("name", [*NAMES, ALL])
def test_the_rest_works_without_a_feature(name: str, tmp_path: Path) -> None:
    gone = set(NAMES) if name == ALL else {name, *users(name)}
    left_without(tmp_path, gone)
    assert do(tmp_path, sys.executable, "-c", "import app; print(app.__file__)").startswith(str(tmp_path))
    do(tmp_path, sys.executable, "-c", IMPORT_ALL)
    said = do(tmp_path, sys.executable, "-m", "app", "--help")
    for feature in FEATURES:
        commands = {} if feature.commands is None else feature.commands()
        assert all((f" {command} " in said) == (feature.name not in gone) for command in commands), (
            feature.name
        )
    assert "--port" in do(tmp_path, sys.executable, "-m", "app", "serve", "--help")
    assert '"d_min"' in do(tmp_path, sys.executable, "-m", "app", "run", "--seconds", "0.2")
    assert do(tmp_path, sys.executable, "-c", VISIT) == "it moves\n"


@pytest.fixture(scope="module")
def core(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the tree without features and their tests."""
    folder = tmp_path_factory.mktemp("core")
    left_without(folder, set(NAMES))
    shutil.rmtree(folder / "tests" / "app" / "features")
    return folder


@pytest.mark.timeout(PATIENCE)
@pytest.mark.parametrize("tests", QUICK)
def test_the_quick_tests_of_the_core_pass_without_any_feature(core: Path, tests: str) -> None:
    do(
        core,
        sys.executable,
        "-m",
        "pytest",
        "-q",
        "-n",
        "0",
        "-m",
        "not slow and not thorough",
        f"tests/{tests}",
    )


def test_positive_control_a_feature_needed_by_the_core_is_found(tmp_path: Path) -> None:
    left_without(tmp_path, set(NAMES))
    path = tmp_path / "app" / "theme.py"
    path.write_text(
        f"from app.features.{NAMES[0]} import feature\n{path.read_text(encoding='utf-8')}", encoding="utf-8"
    )
    with pytest.raises(AssertionError, match=f"app.features.{NAMES[0]}"):
        do(tmp_path, sys.executable, "-c", IMPORT_ALL)


def test_the_tuple_of_features_is_in_order() -> None:
    """A feature uses only features below it in the tuple."""
    for place, name in enumerate(NAMES):
        assert users(name) <= set(NAMES[:place]), f"{name} is used by a feature below it"
