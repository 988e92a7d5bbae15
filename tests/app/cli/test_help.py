"""The help of the command line: three groups of commands, and the most useful options."""

import re
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, cast

import pytest

from app.cli.help import summary
from app.cli.main import commands_with
from app.cli.main import main as command_line
from app.cli.options import shown_alone
from app.cli.serve import IN_BRIEF, SETTINGS_IN_BRIEF
from app.feature import GROUPS, Command, Feature
from app.features import FEATURES
from app.hosting.serve_options import FeatureOptions
from tests.approved import Approve, case_lines


@dataclass(frozen=True)
class Halved:
    """Print the half of a distance.

    It is in metres."""

    distance: float = 0.2


def _print_half(command: Halved) -> int:
    print(command.distance / 2.0)
    return 0


HALVED = Command(Halved, _print_half, "teach")
MADE_UP = Feature("made_up", commands=lambda: {"halved": HALVED})


def said(capsys: pytest.CaptureFixture[str], features: Sequence[Feature], *arguments: str) -> str:
    assert command_line(list(arguments), features) == 0
    out, err = capsys.readouterr()
    assert err == ""
    return out


def groups(text: str) -> dict[str, list[str]]:
    """Group → its lines, each with a command and its summary."""
    found: dict[str, list[str]] = {}
    for paragraph in text.split("\n\n"):
        heading, *lines = paragraph.splitlines()
        if (name := heading.partition(":")[0]) in GROUPS:
            assert name not in found
            found[name] = [line.strip() for line in lines]
    return found


@pytest.mark.parametrize("features", [FEATURES, ()], ids=["all features", "core alone"])
def test_every_command_has_one_line_in_one_group(
    capsys: pytest.CaptureFixture[str], features: Sequence[Feature]
) -> None:
    commands = commands_with(features)
    found = groups(said(capsys, features, "--help"))
    assert list(found) == [
        one for one in GROUPS if any(command.group == one for command in commands.values())
    ]
    named = {line.split()[0]: (group, line) for group, lines in found.items() for line in lines}
    assert sum(map(len, found.values())) == len(named) == len(commands)
    for name, command in commands.items():
        assert named[name] == (command.group, f"{name:{max(map(len, commands))}}  {summary(command)}")


def test_all_three_groups_are_named_in_their_order(capsys: pytest.CaptureFixture[str]) -> None:
    assert GROUPS == ("show", "teach", "compute")
    assert [group for group, lines in groups(said(capsys, [MADE_UP], "--help")).items() if lines] == list(
        GROUPS
    )


def test_the_line_of_a_removed_feature_is_gone(capsys: pytest.CaptureFixture[str]) -> None:
    with_it, without = said(capsys, [MADE_UP], "--help"), said(capsys, [], "--help")
    assert groups(with_it)["teach"] == [f"halved  {summary(HALVED)}"]
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


def test_a_commands_line_is_a_sentence_and_part_of_its_own_help(
    capsys: pytest.CaptureFixture[str],
) -> None:
    for name, command in commands_with(FEATURES).items():
        assert summary(command).endswith("."), name
        with pytest.raises(SystemExit, match="0"):
            command_line([name, "--help"], FEATURES)
        assert summary(command) in capsys.readouterr().out.splitlines(), name


@pytest.mark.parametrize("wrong", ["show ", "Teach", "", None])
def test_an_unknown_group_is_refused_when_the_command_is_declared(wrong: Any) -> None:
    with pytest.raises(ValueError, match="the groups are"):
        Command(Halved, _print_half, wrong)


def test_messages_about_wrong_declarations(approve: Approve) -> None:
    said = []
    for declare in (
        lambda: Command(Halved, _print_half, cast(Any, "show ")),
        lambda: shown_alone(Halved, ["distance", "thirded"]),
    ):
        with pytest.raises(ValueError) as caught:
            declare()
        said.append(str(caught.value))
    approve("wrong declarations.txt", case_lines(dict(zip(("group", "option"), said, strict=True))))


def test_a_command_without_a_group_cannot_be_declared() -> None:
    declare: Any = Command
    with pytest.raises(TypeError, match="group"):
        declare(Halved, _print_half)


def options_of(text: str) -> list[str]:
    """Names of the options in a help text, with or without a frame."""
    return re.findall(r"^. (?:-h, )?(--[a-z-]+)", text, flags=re.MULTILINE)


def help_of(capsys: pytest.CaptureFixture[str], features: Sequence[Feature], *arguments: str) -> str:
    with pytest.raises(SystemExit, match="0"):
        command_line(list(arguments), features)
    out, err = capsys.readouterr()
    assert err == ""
    return out


@pytest.fixture
def narrow(monkeypatch: pytest.MonkeyPatch) -> None:
    """A terminal of 80 columns."""
    monkeypatch.setenv("COLUMNS", "80")


@pytest.mark.usefixtures("narrow")
@pytest.mark.parametrize("features", [FEATURES, ()], ids=["all features", "core alone"])
def test_the_brief_help_of_serve_shows_few_options_and_the_full_one_all(
    capsys: pytest.CaptureFixture[str], features: Sequence[Feature]
) -> None:
    brief, every = (help_of(capsys, features, "serve", option) for option in ("--help", "--help-all"))
    assert set(options_of(brief)) < set(options_of(every)) and len(every.splitlines()) > 150
    declared = {one for feature in features if feature.options for one in feature.options().in_brief}
    expected = {"help", *IN_BRIEF, *SETTINGS_IN_BRIEF, *declared}
    assert sorted(options_of(brief)) == sorted(f"--{one.replace('_', '-')}" for one in expected)
    assert len(expected) <= 13 and len(brief.splitlines()) <= 50


@pytest.mark.usefixtures("narrow")
def test_the_brief_help_of_serve_reads_well(capsys: pytest.CaptureFixture[str], approve: Approve) -> None:
    lines = help_of(capsys, (), "serve", "--help").splitlines()
    approve("brief help.txt", "".join(f"{line.rstrip()}\n" for line in lines))


@pytest.mark.usefixtures("narrow")
def test_the_brief_help_has_the_same_lines_as_the_full_one(capsys: pytest.CaptureFixture[str]) -> None:
    brief, every = (help_of(capsys, FEATURES, "serve", option) for option in ("--help", "--help-all"))
    *shown, _, last = brief.splitlines()
    assert (
        len(shown) > 30
        and [line for line in shown if line not in every.splitlines()] == []
        and last not in every
    )


def test_options_hidden_in_the_brief_help_are_accepted(
    capsys: pytest.CaptureFixture[str],
) -> None:
    # The setting refuses the value, so the option was read.
    assert command_line(["serve", "--dt", "9"], ()) == 2
    assert "dt = '9' is out of range" in capsys.readouterr().err


def test_a_features_options_are_in_the_help_only_with_the_feature(capsys: pytest.CaptureFixture[str]) -> None:
    @dataclass(frozen=True)
    class MadeUpOptions(FeatureOptions):
        """Made up."""

        in_brief = ("often",)
        often: int = 1
        """How often it is halved."""
        seldom: int = 1

    made_up = Feature("made_up", options=lambda: MadeUpOptions)
    brief, without = (help_of(capsys, features, "serve", "--help") for features in ([made_up], []))
    assert "--often" in options_of(brief) and "--seldom" not in options_of(brief)
    assert set(options_of(brief)) - set(options_of(without)) == {"--often"}
    assert {"--often", "--seldom"} <= set(options_of(help_of(capsys, [made_up], "serve", "--help-all")))


def test_an_option_that_does_not_exist_cannot_be_in_the_brief_help() -> None:
    with pytest.raises(ValueError, match="thirded"):
        shown_alone(Halved, ["distance", "thirded"])


@pytest.mark.parametrize("arguments", ["--help-all", "--dm 0.2 --help-all", "serve --dm 9 -h --help-all"])
def test_without_a_command_the_help_is_that_of_serve(
    capsys: pytest.CaptureFixture[str], arguments: str
) -> None:
    assert {"--port", "--dm", "--sessions"} <= set(options_of(help_of(capsys, (), *arguments.split())))


def test_a_command_without_hidden_options_has_one_help(capsys: pytest.CaptureFixture[str]) -> None:
    brief, every = (help_of(capsys, (), "run", option) for option in ("--help", "--help-all"))
    assert brief == every and "--help-all" not in brief


@pytest.mark.usefixtures("narrow")
@pytest.mark.parametrize("coloured", [False, True])
def test_an_error_names_the_help_that_has_the_option(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], coloured: bool, approve: Approve
) -> None:
    # As in a terminal.
    monkeypatch.setattr(sys.stdout, "isatty", lambda: coloured)
    monkeypatch.setenv("TERM", "xterm")
    with pytest.raises(SystemExit, match="2"):
        command_line(["serve", "--bound", "3"], ())
    error = capsys.readouterr().err
    plain = re.sub(r"\x1b\[[\d;]*m", "", error)
    assert coloured == (plain != error)
    # `run` hides no option.
    approve("wrong option.txt", "".join(f"{line.rstrip()}\n" for line in plain.splitlines()))
    assert {len(line) for line in plain.splitlines()} == {80}


@pytest.mark.parametrize("features", [FEATURES, ()], ids=["all features", "core alone"])
@pytest.mark.parametrize("arguments", ["halve", "halve --help", "serve --halve", "serve --bound 3"])
def test_an_unknown_command_or_option_is_named(
    capsys: pytest.CaptureFixture[str], features: Sequence[Feature], arguments: str
) -> None:
    with pytest.raises(SystemExit, match="2"):
        command_line(arguments.split(), features)
    out, err = capsys.readouterr()
    expected = {
        "halve": "Available subcommands: serve, run",
        "halve --help": "halve",
        "serve --halve": "--halve",
    }
    assert out == "" and expected.get(arguments, "--bounds {distance,scale,null_space}") in err
