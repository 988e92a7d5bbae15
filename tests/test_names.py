"""Names and words: one class name has one meaning, a file has a name of its own, and the texts are plain English."""

import ast
import re
from collections import defaultdict

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

SAME_ON_PURPOSE = {
    "activation": "λ; a file of a law may define it, too",
    "law": "what the file of a law defines, and what a cell of a notebook runs",
    "draw": "what the catalogue of figures calls in each of their files",
    "settings.py": "the run's settings, and the page's around them",
    "sweep.py": "the sweep, and the command that starts it",
    "Array": "the same numbers; a law's process and the reader of surfaces import nothing else of ours",
    "Quaternion": "the same four numbers, for a node and for a person's limb",
}
"""Names that stand twice in the product, and why."""

OF_THE_FIELD = {"main": "what a process runs"}
"""Names of functions that the field itself uses again and again, and what for."""

RARE = ("whoever", "nobody", "somebody", "anew", "whose")
"""Words that make a sentence a riddle; each may be used so often in the product and its texts: …"""

MOST = 10


def test_one_name_one_meaning() -> None:
    where: defaultdict[str, list[str]] = defaultdict(list)
    for path in PRODUCT:
        source = path.read_text(encoding="utf-8")
        classes = {node.name for node in ast.parse(source).body if isinstance(node, ast.ClassDef)}
        for name in classes | public_names(source) | ({path.name} - {"__init__.py", "__main__.py"}):
            where[name].append(path.relative_to(ROOT).as_posix())
    assert len(where) > 1500
    twice = {name: files for name, files in where.items() if len(files) > 1}
    assert {name: files for name, files in twice.items() if name not in SAME_ON_PURPOSE} == {}
    assert set(SAME_ON_PURPOSE) <= set(twice), "an exception that is none any more"


def public_names(source: str) -> set[str]:
    """Return the functions and aliases of types at a file's top level."""
    body = ast.parse(source).body
    functions = {node.name for node in body if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)}
    targets = [node.targets[0] for node in body if isinstance(node, ast.Assign)]
    aliases = {target.id for target in targets if isinstance(target, ast.Name) and not target.id.isupper()}
    return {name for name in functions | aliases if not name.startswith("_") and name not in ("log", *OF_THE_FIELD)}


def test_what_counts_as_a_public_name() -> None:
    assert public_names("def a(): ...\nBoth = int | None\nC: int = 1\nD = 2\n_e = 3\nlog = None") == {"a", "Both"}


@pytest.mark.parametrize("word", RARE)
def test_riddle_words_are_rare(word: str) -> None:
    pattern = re.compile(rf"\b{word}\b", re.IGNORECASE)
    found = {path.relative_to(ROOT).as_posix(): n for path in TEXTS if (n := len(pattern.findall(path.read_text("utf-8"))))}
    assert sum(found.values()) <= MOST, found
