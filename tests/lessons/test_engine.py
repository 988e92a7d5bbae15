"""The lessons' engine stands by itself."""

from __future__ import annotations

import ast

from app.lessons import FOLDER


def test_the_engine_knows_no_page() -> None:
    for path in FOLDER.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert not any(name.split(".")[0] in ("viser", "tyro") or name.startswith("app.page") for name in names), path.name
