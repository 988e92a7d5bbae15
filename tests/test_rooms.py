"""The rooms of `app/`: imports go down and never in a circle; one file uses viser's internals."""

import re
import subprocess
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

from tests.test_imports import ROOT, imported

ROOMS = (
    *("lwr_duet", "__main__", "features", "cli", "start", "feature"),
    *("hosting", "page", "recording", "plots", "stage", "session"),
    *("text", "web", "i18n", "runtime", "theme", "settings", "version"),
)
"""Folders and single files of `app/` from the top down, in the order of the documents."""

FLOORS = 15
"""Largest number of rooms on a path of imports."""

INSIDE = re.compile(r"viser\._|viser\.infra|_websock_server|_live_connections|\b_impl\b|_viser_server")
"""Viser's private names."""

DOOR = "app/web/viser_internals.py"
"""The only file that may use viser's private names."""

FLOORS_OF_CODE = ("app", "scenes", "controllers")
PRODUCT = sorted(
    path.relative_to(ROOT).as_posix() for floor in FLOORS_OF_CODE for path in (ROOT / floor).rglob("*.py")
)
FILES = [file for file in PRODUCT if file.startswith("app/")]
MODULES = {file.removesuffix(".py").replace("/", ".").removesuffix(".__init__"): file for file in PRODUCT}


def room_of(file: str) -> str:
    parts = file.split("/")
    return parts[1] if len(parts) > 2 else parts[1].removesuffix(".py")


def modules(source: str) -> Iterator[str]:
    for name in imported(source):
        while name and name not in MODULES:
            name = name.rpartition(".")[0]
        if name:
            yield name


def arrows() -> dict[str, set[str]]:
    return {
        file: {MODULES[m] for m in modules((ROOT / file).read_text(encoding="utf-8"))} - {file}
        for file in PRODUCT
    }


def upward(file: str, source: str) -> list[str]:
    """Imports of a file from rooms above its own."""
    here = ROOMS.index(room_of(file))
    return [m for m in modules(source) if m.startswith("app.") and ROOMS.index(room_of(MODULES[m])) < here]


def test_every_folder_is_a_room_and_single_files_are_few() -> None:
    found = {room_of(file) for file in FILES} - {"__init__"}
    assert found == set(ROOMS)
    assert len([file for file in FILES if file.count("/") == 1]) <= 8


@pytest.mark.parametrize("file", [file for file in FILES if file != "app/__init__.py"])
def test_a_room_imports_only_rooms_below_it(file: str) -> None:
    assert upward(file, (ROOT / file).read_text(encoding="utf-8")) == []


def test_positive_control_an_import_upwards_is_found() -> None:
    plain = "from app.page.view import View"
    nested = (
        f"def late():\n    {plain}",
        f"from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    {plain}",
    )
    for source in (plain, "import app.page.view", "from app.page import view", *nested):
        assert upward("app/session/session.py", source), source


def test_imports_are_not_circular() -> None:
    try:
        TopologicalSorter(arrows()).prepare()
    except CycleError as error:
        pytest.fail(f"these files import each other in a circle: {error.args[1]}")


def test_import_paths_through_the_rooms_are_short() -> None:
    below: dict[str, set[str]] = {room: set() for room in ROOMS}
    found = arrows()
    for file in FILES:
        if room_of(file) in below:
            used = found[file] & set(FILES)
            below[room_of(file)] |= {room_of(other) for other in used} - {"__init__", room_of(file)}
    floor: dict[str, int] = {}
    for room in TopologicalSorter(below).static_order():
        floor[room] = 1 + max((floor[other] for other in below[room]), default=0)
    assert max(floor.values()) <= FLOORS, floor


@pytest.mark.parametrize("floor", ["app", "scenes", "controllers"])
def test_viser_s_private_names_are_in_one_file(floor: str) -> None:
    said = {
        path.relative_to(ROOT).as_posix(): found
        for path in (ROOT / floor).rglob("*.py")
        if (found := INSIDE.findall(path.read_text(encoding="utf-8")))
    }
    if floor == "app":
        assert said.pop(DOOR), "positive control: the pattern finds no private name in this file"
    assert said == {}


def test_scripts_are_in_their_own_files() -> None:
    script = re.compile(r"addEventListener\(|document\.querySelector|=>\s*\{")
    found = [file for file in FILES if script.search((ROOT / file).read_text(encoding="utf-8"))]
    assert found == []
    assert any(script.search(path.read_text(encoding="utf-8")) for path in Path(ROOT / "app").rglob("*.js"))


def test_the_top_level_contains_the_floors_and_few_files() -> None:
    listed = subprocess.run(
        ["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout.splitlines()
    top = {line.split("/", 1)[0] for line in listed if not line.startswith(".")}
    assert top == {
        *("app", "controllers", "scenes", "tests"),
        *("pyproject.toml", "README.md", "LICENSE", "requirements.lock"),
    }


def test_tests_mirror_the_rooms() -> None:
    folder = ROOT / "tests" / "app"
    rooms = {path.name for path in folder.iterdir() if path.is_dir() and path.name != "__pycache__"}
    assert rooms <= set(ROOMS)
    # tests/test_deploy.py tests the installed `lwr_duet`.
    assert {room for room in ROOMS if (ROOT / "app" / room).is_dir()} - {"lwr_duet"} <= rooms
    loose = {path.stem.removeprefix("test_") for path in folder.glob("test_*.py")}
    assert loose <= {path.stem for path in (ROOT / "app").glob("*.py")}
