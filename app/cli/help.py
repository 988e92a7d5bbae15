"""The help of `lwr-duet`: three groups, with a line for each command."""

from collections.abc import Mapping
from inspect import getdoc
from typing import Final

from app.feature import GROUPS, Command, Group

HELP: Final = ("-h", "--help")
"""Options that ask for help."""

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
    """Help that names every command in its group; a group without a command is left out."""
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
    """First line of the command's help."""
    return (getdoc(command.options) or "").partition("\n")[0]
