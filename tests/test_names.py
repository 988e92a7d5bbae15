"""Names and words: one class name has one meaning, a file has a name of its own, and the texts are plain English."""

from __future__ import annotations

import ast
import re
from collections import defaultdict
from pathlib import Path

import pytest

from tests.test_imports import ROOT

PRODUCT = [path for floor in ("app", "scenes", "controllers") for path in sorted((ROOT / floor).rglob("*.py"))]
TEXTS = [
    *PRODUCT,
    *(ROOT / "app").rglob("*.js"),
    *(ROOT / "app").rglob("*.css"),
    *(path for path in (ROOT / "app").rglob("*.toml")),
    *(path for path in (ROOT / "app").rglob("*.md")),
    ROOT / "README.md",
]

SAME_FILE_NAMES = {
    "settings.py": "the run's settings, and the page's around them",
    "sweep.py": "the sweep, and the command that starts it",
}
"""File names that stand twice, and why."""

RARE = ("whoever", "nobody", "somebody", "anew", "whose")
"""Words that make a sentence a riddle; each may be used so often in the product and its texts: …"""

MOST = 10


def test_one_class_name_one_meaning() -> None:
    where: defaultdict[str, list[str]] = defaultdict(list)
    for path in PRODUCT:
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.ClassDef):
                where[node.name].append(path.relative_to(ROOT).as_posix())
    assert len(where) > 200
    assert {name: files for name, files in where.items() if len(files) > 1} == {}


@pytest.mark.parametrize("word", RARE)
def test_riddle_words_are_rare(word: str) -> None:
    pattern = re.compile(rf"\b{word}\b", re.IGNORECASE)
    found = {path.relative_to(ROOT).as_posix(): n for path in TEXTS if (n := len(pattern.findall(path.read_text("utf-8"))))}
    assert sum(found.values()) <= MOST, found


def test_names_of_files_are_unique() -> None:
    """A file's name makes sense without its folder, so no two modules of a package share one."""
    seen: defaultdict[str, list[Path]] = defaultdict(list)
    for path in PRODUCT:
        if path.name not in ("__init__.py", "__main__.py"):
            seen[path.name].append(path.relative_to(ROOT))
    twice = {name: paths for name, paths in seen.items() if len(paths) > 1}
    assert {name: paths for name, paths in twice.items() if name not in SAME_FILE_NAMES} == {}
    assert set(SAME_FILE_NAMES) <= set(twice), "an exception that is none any more"
