"""Approved texts: a test's text is compared with a file in the folder `approved` next to the test.

After a wanted change, `pytest --approve` writes the files; read the diff before the commit.
"""

import re
from collections.abc import Callable, Mapping
from html import unescape
from pathlib import Path

import pytest

Approve = Callable[[str, str], None]
"""(file name, text) → compares them; may be called several times."""

FOLDER = "approved"


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--approve", action="store_true", help="write the approved texts instead of comparing them"
    )


@pytest.fixture
def approve(request: pytest.FixtureRequest) -> Approve:
    folder, writes = request.path.parent / FOLDER, bool(request.config.getoption("approve"))

    def compare(name: str, text: str) -> None:
        path = folder / name
        if writes:
            path.parent.mkdir(exist_ok=True)
            path.write_text(text, encoding="utf-8")
        wanted = path.read_text(encoding="utf-8") if path.exists() else ""
        assert text.splitlines() == wanted.splitlines(), (
            f"{path.name} has changed; read the diff, then pytest --approve"
        )

    return compare


def shown_text(html: object) -> str:
    """Text of HTML, one line for the text between two tags."""
    lines = (" ".join(part.split()) for part in unescape(re.sub(r"<[^>]+>", "\n", str(html))).splitlines())
    return "\n".join(line for line in lines if line) + "\n"


def case_lines(said: Mapping[str, object]) -> str:
    """Lines `case: message`."""
    return "".join(f"{case}: {text}\n" for case, text in said.items())


def without_numbers(text: str) -> str:
    """The text with each number as #, for numbers from a simulation."""
    return re.sub(r"\d+(?:[.,]\d+)*(?:e[+-]?\d+)?", "#", text)


def approved_files(root: Path) -> list[Path]:
    return sorted(path for folder in root.rglob(FOLDER) if folder.is_dir() for path in folder.iterdir())
