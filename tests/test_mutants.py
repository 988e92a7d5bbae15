"""The mutants of `tests.tools.mutants`: each is another program, and a test of the changed code finds it."""

import ast
from pathlib import Path

import pytest

from tests.tools.mutants.__main__ import draw, interval, table
from tests.tools.mutants.near_tests import ImportGraph
from tests.tools.mutants.operators import changed, changes
from tests.tools.mutants.trials import Copy

SOURCE = '''
"""A docstring with 1 + 1."""
import logging
_log = logging.getLogger("ü")

def share(part: float, whole: float = 2.0) -> float:
    """Part of 1."""
    if whole <= 0.0 or part is None:
        raise ValueError(f"{1 + 1} is wrong")
    _log.info("share %s", 1 + 1)
    values = [part, whole][:2]
    values.append(divmod(part, whole)[0])
    return min(part / whole, 1.0)
'''
KINDS = {
    "comparison", "arithmetic", "constant", "condition", "return",
    "minimum, maximum", "and, or", "argument order", "slice", "deletion",
}  # fmt: skip


def test_every_kind_of_mistake_gives_another_valid_program() -> None:
    found = changes(SOURCE)
    assert {change.operator for change in found} == KINDS
    texts = [changed(SOURCE, change) for change in found]
    assert all(
        text is not None and ast.dump(ast.parse(text)) != ast.dump(ast.parse(SOURCE)) for text in texts
    )


def test_texts_hints_logs_and_exceptions_are_kept() -> None:
    kept = ("A docstring with 1 + 1", "Part of 1.", 'f"{1 + 1} is wrong"', '"share %s", 1 + 1', "part: float")
    for change in changes(SOURCE):
        text = changed(SOURCE, change)
        assert text is not None
        assert all(piece in text for piece in kept), change


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """A tiny tree with a tested and an untested module."""
    texts = {
        "pyproject.toml": "[tool.pytest.ini_options]\nmarkers = ['slow: s', 'thorough: t']\n",
        "controllers/__init__.py": "",
        "controllers/tested.py": "def double(x: int) -> int:\n    return x * 2\n",
        "controllers/untested.py": "def half(x: int) -> float:\n    return x / 2\n",
        "tests/__init__.py": "",
        "tests/controllers/__init__.py": "",
        "tests/controllers/test_tested.py": (
            "import controllers.tested\n\ndef test_double() -> None:\n    assert controllers.tested.double(3) == 6\n"
        ),
    }
    for name, text in texts.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path


@pytest.mark.thorough
def test_a_tested_mutant_is_killed_and_an_untested_one_survives(tree: Path) -> None:
    graph = ImportGraph(tree, ("controllers",))
    copy = Copy(tree, limit=60.0, budget=20.0)
    mutants = draw(tree, {"controllers": 100}, seed=1)
    try:
        verdicts = {
            (mutant.file, copy.judge(mutant.file, mutant.text, copy.chosen(graph.near(mutant.file))).verdict)
            for mutant in mutants
        }
    finally:
        copy.close()
    assert verdicts == {("controllers/tested.py", "killed"), ("controllers/untested.py", "survived")}
    assert "x * 2" in (tree / "controllers/tested.py").read_text(encoding="utf-8")


def test_the_same_seed_draws_the_same_mutants(tree: Path) -> None:
    assert draw(tree, {"controllers": 5}, seed=3) == draw(tree, {"controllers": 5}, seed=3)


def test_the_table_gives_shares_with_their_interval() -> None:
    assert interval(0, 0) == (0.0, 1.0)
    low, high = interval(8, 10)
    assert low == pytest.approx(0.490, abs=1e-3) and high == pytest.approx(0.943, abs=1e-3)
    assert "| all | 1 | 1 | 1 | 50 |" in table([("a", "killed"), ("b", "survived"), ("b", "slow")])
