"""Help of `lwr-duet`, three groups with a line per command, and of each command."""

import io
import re
import sys
from collections.abc import Mapping, Sequence
from contextlib import redirect_stderr
from inspect import getdoc
from typing import Any, Final

import tyro

from app.feature import GROUPS, Command, Group

HELP: Final = ("-h", "--help")

HELP_ALL: Final = "--help-all"

_TOP: Final = """\
usage: lwr-duet [COMMAND] [OPTIONS]

Duet: smooth transition between tasks, shown on two KUKA LWR arms
(Petrič & Žlajpah, ROBIO 2011). Without a command it opens the page.
"""

_HEADINGS: Final[Mapping[Group, str]] = {
    "show": "the page and pictures",
    "teach": "a class and its homework",
    "compute": "runs without a page",
}


def top_help(commands: Mapping[str, Command]) -> str:
    """Help with every command in its group; empty groups are left out."""
    width = max(map(len, commands))
    lines = [_TOP]
    for group in GROUPS:
        members = [name for name, command in commands.items() if command.group == group]
        if members:
            lines.append(f"{group}: {_HEADINGS[group]}")
            lines += [f"  {name:{width}}  {summary(commands[name])}" for name in members]
            lines.append("")
    lines.append("Options of a command: lwr-duet COMMAND --help")
    return "\n".join(lines)


def summary(command: Command) -> str:
    return (getdoc(command.options) or "").partition("\n")[0]


def print_help(commands: Mapping[str, Command], name: str, is_all: bool) -> None:
    """Print the help of one command.

    Args:
        is_all: also show the options that are not in its brief help.

    Raises:
        SystemExit: always, with code 0, as tyro does after a help.
    """
    brief = None if is_all else commands[name].brief
    options = {one: command.options for one, command in commands.items()}
    if brief is not None:
        options[name] = brief()
    try:
        parse(options, [name, HELP[-1]])
    finally:
        if brief is not None:
            print(f"\nAll options: lwr-duet {name} {HELP_ALL}")


def read_arguments(commands: Mapping[str, Command], arguments: Sequence[str]) -> Any:
    """Options from the arguments of the command line; an error names the help that has every option.

    Raises:
        SystemExit: an error was printed on stderr.
    """
    error = io.StringIO()
    try:
        with redirect_stderr(error):
            return parse({name: command.options for name, command in commands.items()}, arguments)
    finally:
        brief = [name for name, command in commands.items() if command.brief is not None]
        sys.stderr.write(_naming_full_help(error.getvalue(), brief))


def _naming_full_help(error: str, names: Sequence[str]) -> str:
    """The error with `--help-all` instead of `--help` of these commands; in a terminal each word has its
    colour.
    """
    added, colour = HELP_ALL.removeprefix(HELP[-1]), r"(?:\x1b\[[\d;]*m)*"
    for name in names:
        # Remove as many blanks as were added, so that the frame stays straight.
        pattern = rf"(lwr-duet{colour} {re.escape(name)}{colour} {HELP[-1]})({colour}) {{{len(added)}}}"
        error = re.sub(pattern, rf"\1{added}\2", error)
    return error


def parse(options: Mapping[str, type], arguments: Sequence[str]) -> Any:
    """Options from the arguments of the command line.

    Raises:
        SystemExit: help was printed, or an error on stderr.
    """
    return tyro.extras.subcommand_cli_from_dict(dict(options), prog="lwr-duet", args=arguments)
