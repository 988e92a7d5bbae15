"""One class name has one meaning."""

import ast
from collections import defaultdict

from tests.test_imports import ROOT

PRODUCT = [
    path for floor in ("app", "scenes", "controllers") for path in sorted((ROOT / floor).rglob("*.py"))
]


def test_one_class_name_has_one_meaning() -> None:
    where: defaultdict[str, list[str]] = defaultdict(list)
    for path in PRODUCT:
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.ClassDef):
                where[node.name].append(path.relative_to(ROOT).as_posix())
    assert len(where) > 400
    assert {name: files for name, files in where.items() if len(files) > 1} == {}
