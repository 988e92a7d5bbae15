"""Texts that people read as a whole: the help of every command, and what is said of a bad setting in each language."""

import re
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
def test_what_is_said_of_a_bad_setting(language: str, approve: Approve) -> None:
    said = []
    for key in specs(Settings):
        for value in BAD:
            try:
                changed(Settings(), key, value)
            except BadSetting as error:
                said.append(f"{key}={value}: {words_of(language)(str(error))}")
    assert len(said) > 50
    approve(f"bad settings {language}.txt", "\n".join(said) + "\n")


def test_every_approved_text_belongs_to_a_test() -> None:
    """The name of a file begins with a word that a test beside it uses."""
    root = Path(__file__).parents[2]
    left = [
        str(path.relative_to(root))
        for path in approved_files(root)
        if not any(
            re.search(
                rf'approve\(\s*f?"{re.escape(path.name.split()[0])}\b', test.read_text(encoding="utf-8")
            )
            for test in path.parents[1].glob("test_*.py")
        )
    ]
    assert left == []
