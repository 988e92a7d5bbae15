"""Test files near a module, by their imports and their folder."""

import ast
from collections import defaultdict
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path, PurePosixPath
from typing import Final

FAR: Final = 99
"""Distance of a test that does not import the module, directly or indirectly."""


class ImportGraph:
    """Imports in a source tree.

    Args:
        root: folder of the tree, with `tests` next to the packages.
        packages: folders with the modules that count.
    """

    def __init__(self, root: Path, packages: tuple[str, ...]) -> None:
        self._files = {
            _module_name(file.relative_to(root)): file
            for package in (*packages, "tests")
            for file in sorted((root / package).rglob("*.py"))
        }
        self._root = root

    @cached_property
    def _importers(self) -> dict[str, set[str]]:
        importers: dict[str, set[str]] = defaultdict(set)
        for name, file in self._files.items():
            for one in imported(file.read_text(encoding="utf-8")):
                # The longest prefix that is a module: `from scenes.room import Room` imports `scenes.room`.
                while one and one not in self._files:
                    one = one.rpartition(".")[0]
                if one and one != name:
                    importers[one].add(name)
        return importers

    def near(self, module: str) -> list[str]:
        """Test files near a module, the nearest first.

        First files that import it, starting with the one of its name; then those of the folder that mirrors
        its own, by distance; then others two imports away.

        Args:
            module: its file below the root, with slashes.

        Returns:
            Files below the root.
        """
        path = PurePosixPath(module)
        distances = self._distances(_module_name(path))
        mirror = PurePosixPath("tests") / path.parent
        while not (self._root / mirror).is_dir():
            mirror = mirror.parent
        found: list[tuple[bool, bool, bool, int, str]] = []
        for name, absolute in self._files.items():
            file = PurePosixPath(absolute.relative_to(self._root).as_posix())
            distance = distances.get(name, FAR)
            mirrored = mirror in file.parents and mirror != PurePosixPath("tests")
            if file.parts[0] == "tests" and file.name.startswith("test_") and (distance <= 2 or mirrored):
                own = file.name == f"test_{path.name}"
                found.append((distance > 1, not own, not mirrored, distance, str(file)))
        return [file for *_, file in sorted(found)]

    def _distances(self, module: str) -> dict[str, int]:
        """Number of imports from the module to each direct or indirect importer."""
        distances = {module: 0}
        queue = [module]
        for one in queue:
            for importer in sorted(self._importers.get(one, ())):
                if importer not in distances:
                    distances[importer] = distances[one] + 1
                    queue.append(importer)
        return distances


def imported(source: str) -> Iterator[str]:
    """Full names of all imports anywhere in a source text."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def _module_name(file: Path | PurePosixPath) -> str:
    parts = file.with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
