"""Forbidden habits of language in docstrings and comments; see `app/documents/code.md`."""

import re
from pathlib import Path

import pytest

from tests.test_imports import ROOT

HABITS = {
    "Return whether, what, how, where, who: name what is returned": re.compile(
        r"\bReturn (?:whether|what|how|where|who)\b"
    ),
    "None for none: say when it is None": re.compile(r"\bNone for none\b", re.IGNORECASE),
    "so many: name the number": re.compile(r"\bso many\b", re.IGNORECASE),
    "a caption that continues the one before": re.compile(r'^\s*"""…', re.MULTILINE),
}


def files() -> list[Path]:
    found = [
        path
        for folder in ("controllers", "scenes", "app", "tests")
        for path in sorted((ROOT / folder).rglob("*.py"))
    ]
    return [path for path in found if path != Path(__file__)]


@pytest.mark.parametrize("habit", HABITS)
def test_no_file_has_the_habit(habit: str) -> None:
    found = [
        f"{path.relative_to(ROOT)}:{text.count(chr(10), 0, match.start()) + 1}"
        for path in files()
        for text in [path.read_text(encoding="utf-8")]
        for match in HABITS[habit].finditer(text)
    ]
    assert found == []


EXAMPLES = (
    '"""Return whether it runs."""',
    "a law; None for none.",
    "after so many steps",
    '\n"""… and this."""',
)


@pytest.mark.parametrize(("habit", "text"), list(zip(HABITS, EXAMPLES, strict=True)))
def test_the_habits_are_found(habit: str, text: str) -> None:
    assert HABITS[habit].search(text)
