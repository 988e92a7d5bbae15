"""Names and words: one class name has one meaning, and the texts are plain English."""

import ast
import re
from collections import defaultdict

import pytest

from tests.test_imports import ROOT

PRODUCT = [
    path for floor in ("app", "scenes", "controllers") for path in sorted((ROOT / floor).rglob("*.py"))
]
TEXTS = [
    *PRODUCT,
    *(ROOT / "app").rglob("*.js"),
    *(ROOT / "app").rglob("*.css"),
    *(path for path in (ROOT / "app").rglob("*.toml")),
    *(path for path in (ROOT / "app").rglob("*.md")),
    ROOT / "README.md",
]

RARE = ("whoever", "nobody", "somebody", "anew", "whose")
"""Words that make a sentence a riddle; each may be used so often in the product and its texts: …"""

MOST = 10


def test_one_class_name_has_one_meaning() -> None:
    where: defaultdict[str, list[str]] = defaultdict(list)
    for path in PRODUCT:
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.ClassDef):
                where[node.name].append(path.relative_to(ROOT).as_posix())
    assert len(where) > 400
    assert {name: files for name, files in where.items() if len(files) > 1} == {}


@pytest.mark.parametrize("word", RARE)
def test_riddle_words_are_rare(word: str) -> None:
    pattern = re.compile(rf"\b{word}\b", re.IGNORECASE)
    found = {
        path.relative_to(ROOT).as_posix(): n
        for path in TEXTS
        if (n := len(pattern.findall(path.read_text("utf-8"))))
    }
    assert sum(found.values()) <= MOST, found
