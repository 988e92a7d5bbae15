"""Imports go down only, from the page over the rooms to the mathematics; a notebook's names exist."""

import ast
import importlib
import pkgutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
FORBIDDEN: dict[str, frozenset[str]] = {
    "controllers": frozenset({"scenes", "app", "tests", "viser", "tyro", "yourdfpy", "trimesh"}),
    "scenes": frozenset({"app", "tests", "viser", "tyro"}),
    "app": frozenset({"tests"}),
}


def imported(source: str) -> Iterator[str]:
    """Full names of all imports anywhere in a source text."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level != 1:
            # A relative import with one dot stays on its floor; imports with more dots are not allowed.
            yield from (f"{'.' * node.level}{node.module or ''}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Call) and isinstance(node.func, (ast.Name, ast.Attribute)):
            name = node.func.id if isinstance(node.func, ast.Name) else node.func.attr
            if (
                name in ("import_module", "__import__")
                and node.args
                and isinstance(node.args[0], ast.Constant)
            ):
                yield str(node.args[0].value)


def wrong(floor: str, source: str) -> set[str]:
    return {name for name in imported(source) if name.split(".")[0] in FORBIDDEN[floor] | {""}}


@pytest.mark.parametrize("floor", FORBIDDEN)
def test_imports_go_down_only(floor: str) -> None:
    files = sorted((ROOT / floor).rglob("*.py"))
    assert len(files) > 5
    found = {
        str(file.relative_to(ROOT)): names
        for file in files
        if (names := wrong(floor, file.read_text(encoding="utf-8")))
    }
    assert not found


UPWARDS = {
    "controllers": ("import scenes.room", "from scenes import room", "from app.page import theme as t", "import numpy, trimesh",
                    "def late():\n    import viser.transforms", "if TYPE_CHECKING:\n    from scenes.room import Room",
                    "from .. import app"),
    "scenes": ("import viser", "from tyro.conf import arg", "import importlib\nimportlib.import_module('app.web')",
               "__import__('viser')"),
    "app": ("from tests.browser import page_at",),
}  # fmt: skip
DOWNWARDS = {
    "controllers": ("import numpy as np\nfrom controllers.laws import situation\nfrom . import errors",
                    "text = 'import viser'  # import scenes"),
    "scenes": ("from controllers.kinematics import Array\nimport trimesh",),
    "app": ("import viser, tyro\nfrom scenes.room import build_room",),
}  # fmt: skip


def test_positive_control_only_imports_upwards_are_found() -> None:
    for table, found in ((UPWARDS, True), (DOWNWARDS, False)):
        for floor, sources in table.items():
            assert {source: bool(wrong(floor, source)) for source in sources} == dict.fromkeys(sources, found)


@pytest.mark.parametrize("package", ["controllers", "scenes"])
def test_every_public_name_exists_and_is_not_a_module(package: str) -> None:
    loaded = importlib.import_module(package)
    public = loaded._PUBLIC
    names = [name for name in dir(loaded) if name in public]
    assert len(names) == len(public) >= 10
    assert not {module.name for module in pkgutil.iter_modules(loaded.__path__)} & set(names)
    assert all(getattr(loaded, name).__doc__ for name in names if callable(getattr(loaded, name)))
    with pytest.raises(AttributeError, match=names[0]):
        _ = loaded.no_such_name


def test_settings_load_no_robot() -> None:
    code = "import sys; from scenes import RunSettings; RunSettings(); print('pinocchio' in sys.modules)"
    assert (
        subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True, check=True
        ).stdout.strip()
        == "False"
    )
