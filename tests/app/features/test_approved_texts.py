"""Texts read as a whole: the help of every command, and the messages about bad settings in each language."""

import ast
import re
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import pytest

from app.cli.main import commands_with
from app.cli.main import main as command_line
from app.features import FEATURES
from app.i18n.catalogue import words_of
from app.settings import LANGUAGES, Settings
from controllers.errors import BadSetting
from scenes.settings import changed, specs
from tests.approved import Approve, approved_files

ROOT = Path(__file__).parents[2]
NARROW = 90
"""Width of the terminal [columns]."""

BAD = ("x", "1e9")
"""Values that a setting refuses, unless it is a text."""


@pytest.mark.parametrize("command", [*commands_with(FEATURES), ""], ids=lambda name: name or "all commands")
def test_the_help_of_a_command(
    command: str, approve: Approve, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("COLUMNS", str(NARROW))
    asked = [command, "--help-all"] if command else ["--help"]
    try:
        assert command_line(asked, FEATURES) == 0
    except SystemExit as end:
        assert end.code == 0
    lines = [line.rstrip() for line in capsys.readouterr().out.splitlines()]
    approve(f"help {command or 'all'}.txt", "\n".join(lines) + "\n")


@pytest.mark.parametrize("language", LANGUAGES)
def test_messages_about_bad_settings(language: str, approve: Approve) -> None:
    said = []
    for key in specs(Settings):
        for value in BAD:
            try:
                changed(Settings(), key, value)
            except BadSetting as error:
                said.append(f"{key}={value}: {words_of(language)(str(error))}")
    assert len(said) > 50
    approve(f"bad settings {language}.txt", "\n".join(said) + "\n")


def approved_names(test: Path) -> Iterator[str]:
    """Patterns of the names that a test file gives to `approve`; inserted values match any text."""
    for node in ast.walk(ast.parse(test.read_text(encoding="utf-8"))):
        match node:
            case ast.Call(func=ast.Name("approve"), args=[ast.Constant(str(name)), *_]):
                yield re.escape(name)
            case ast.Call(func=ast.Name("approve"), args=[ast.JoinedStr(parts), *_]):
                yield "".join(
                    re.escape(str(part.value)) if isinstance(part, ast.Constant) else ".+" for part in parts
                )


def test_every_approved_text_belongs_to_a_test() -> None:
    files = defaultdict[Path, list[Path]](list)
    for path in approved_files(ROOT):
        files[path.parents[1]].append(path)
    left: list[str] = []
    for folder, texts in files.items():
        names = [name for test in folder.glob("test_*.py") for name in approved_names(test)]
        left += [
            str(path.relative_to(ROOT))
            for path in texts
            if not any(re.fullmatch(name, path.name) for name in names)
        ]
    assert left == []
