"""The help of the command line: three groups of commands, and the options that a person needs."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import pytest

from app.cli.help import summary
from app.cli.main import commands_with
from app.cli.main import main as command_line
from app.feature import GROUPS, Command, Feature
from app.features import FEATURES


@dataclass(frozen=True)
class Halved:
    """Print the half of a distance.

    It is in metres."""

    distance: float = 0.2


def _print_half(command: Halved) -> int:
    print(command.distance / 2.0)
    return 0


MADE_UP = Feature("made_up", commands=lambda: {"halved": Command(Halved, _print_half, "teach")})


def said(capsys: pytest.CaptureFixture[str], features: Sequence[Feature], *arguments: str) -> str:
    assert command_line(list(arguments), features) == 0
    out, err = capsys.readouterr()
    assert err == ""
    return out


def groups(text: str) -> dict[str, list[str]]:
    """Group → its lines, each a command and what it does."""
    found: dict[str, list[str]] = {}
    for paragraph in text.split("\n\n"):
        heading, *lines = paragraph.splitlines()
        if (name := heading.partition(":")[0]) in GROUPS:
            assert name not in found
            found[name] = [line.strip() for line in lines]
    return found


@pytest.mark.parametrize("features", [FEATURES, ()], ids=["all features", "core alone"])
def test_every_command_has_one_line_in_one_group(capsys: pytest.CaptureFixture[str], features: Sequence[Feature]) -> None:
    commands = commands_with(features)
    found = groups(said(capsys, features, "--help"))
    assert list(found) == [one for one in GROUPS if any(command.group == one for command in commands.values())]
    named = {line.split()[0]: (group, line) for group, lines in found.items() for line in lines}
    assert sum(map(len, found.values())) == len(named) == len(commands)
    for name, command in commands.items():
        assert named[name] == (command.group, f"{name:{max(map(len, commands))}}  {summary(command)}")


def test_all_three_groups_are_named_in_their_order(capsys: pytest.CaptureFixture[str]) -> None:
    assert GROUPS == ("show", "teach", "compute")
    assert [group for group, lines in groups(said(capsys, [MADE_UP], "--help")).items() if lines] == list(GROUPS)


def test_a_feature_that_is_taken_out_takes_its_line_with_it(capsys: pytest.CaptureFixture[str]) -> None:
    with_it, without = said(capsys, [MADE_UP], "--help"), said(capsys, [], "--help")
    assert groups(with_it)["teach"] == ["halved  Print the half of a distance."]
    assert "halved" not in without and "teach" not in groups(without)


@pytest.mark.parametrize("help_option", ["-h", "--help"])
def test_the_help_is_the_same_in_every_terminal(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], help_option: str
) -> None:
    texts = set[str]()
    for columns in ("30", "300"):
        monkeypatch.setenv("COLUMNS", columns)
        texts.add(said(capsys, FEATURES, help_option))
    (text,) = texts
    assert max(map(len, text.splitlines())) <= 80 and "\x1b" not in text


def test_the_line_of_a_command_is_a_sentence_that_its_own_help_repeats(capsys: pytest.CaptureFixture[str]) -> None:
    for name, command in commands_with(FEATURES).items():
        assert summary(command).endswith("."), name
        with pytest.raises(SystemExit, match="0"):
            command_line([name, "--help"], FEATURES)
        assert summary(command) in capsys.readouterr().out.splitlines(), name


@pytest.mark.parametrize("wrong", ["show ", "Teach", "", None])
def test_an_unknown_group_is_refused_when_the_command_is_declared(wrong: Any) -> None:
    with pytest.raises(ValueError, match="the groups are show, teach, compute"):
        Command(Halved, _print_half, wrong)


def test_a_command_without_a_group_cannot_be_declared() -> None:
    declare: Any = Command
    with pytest.raises(TypeError, match="group"):
        declare(Halved, _print_half)
