"""Imports go down only: the page may use the rooms, the rooms the mathematics, and never the other way round."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
FORBIDDEN: dict[str, frozenset[str]] = {
    "controllers": frozenset({"scenes", "app", "tests", "viser", "tyro", "yourdfpy", "trimesh"}),
    "scenes": frozenset({"app", "tests", "viser", "tyro"}),
    "app": frozenset({"tests"}),
    "app/lessons": frozenset({"viser", "tyro"}),
}


def imported(source: str) -> Iterator[str]:
    """Yield the full name of everything that a source imports, anywhere in it."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level != 1:
            # A relative import with a single dot stays on its floor; more dots would have to be counted, so none may have them.
            yield from (f"{'.' * node.level}{node.module or ''}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Call) and isinstance(node.func, (ast.Name, ast.Attribute)):
            name = node.func.id if isinstance(node.func, ast.Name) else node.func.attr
            if name in ("import_module", "__import__") and node.args and isinstance(node.args[0], ast.Constant):
                yield str(node.args[0].value)


def wrong(floor: str, source: str) -> set[str]:
    return {name for name in imported(source) if name.split(".")[0] in FORBIDDEN[floor] | {""}}


@pytest.mark.parametrize("floor", FORBIDDEN)
def test_imports_go_down_only(floor: str) -> None:
    files = sorted((ROOT / floor).rglob("*.py"))
    assert len(files) > 5
    found = {str(file.relative_to(ROOT)): names for file in files if (names := wrong(floor, file.read_text(encoding="utf-8")))}
    assert not found


@pytest.mark.parametrize(
    ("floor", "source"),
    [
        ("controllers", "import scenes.room"),
        ("controllers", "from scenes import room"),
        ("controllers", "from app.page import theme as t"),
        ("controllers", "def late():\n    import viser.transforms"),
        ("controllers", "if TYPE_CHECKING:\n    from scenes.room import Room"),
        ("controllers", "import numpy, trimesh"),
        ("controllers", "from .. import app"),
        ("scenes", "import viser"),
        ("scenes", "from tyro.conf import arg"),
        ("scenes", "import importlib\nimportlib.import_module('app.web')"),
        ("scenes", "__import__('viser')"),
        ("app", "from tests.browser import page_at"),
        ("app/lessons", "import viser"),
    ],
)
def test_positive_control_an_import_upwards_is_found(floor: str, source: str) -> None:
    assert wrong(floor, source)


@pytest.mark.parametrize(
    ("floor", "source"),
    [
        ("controllers", "import numpy as np\nfrom controllers.laws import situation\nfrom . import errors"),
        ("scenes", "from controllers.kinematics import Array\nimport trimesh"),
        ("app", "import viser, tyro\nfrom scenes.room import build_room"),
        ("controllers", "text = 'import viser'  # import scenes"),
    ],
)
def test_imports_downwards_are_fine(floor: str, source: str) -> None:
    assert not wrong(floor, source)
