"""The command line: reads the arguments and calls the command that they name; `serve` without one."""

import sys
from collections.abc import Sequence
from functools import partial

import tyro

from app.cli.help import HELP, top_help
from app.cli.run import run_with, simulate
from app.cli.serve import serve, serve_with
from app.feature import Command, Feature
from app.runtime.terminal import write_log
from controllers.errors import DuetError


def commands_with(features: Sequence[Feature]) -> dict[str, Command]:
    """Commands of the core, then those of the features, the lowest feature first."""
    commands = {
        "serve": Command(serve_with(features), partial(serve, features=features), "show"),
        "run": Command(run_with(features), partial(simulate, features=features), "compute"),
    }
    for feature in reversed(features):
        if feature.commands is not None:
            commands |= feature.commands()
    return commands


def main(arguments: list[str] | None, features: Sequence[Feature]) -> int:
    """Run the command line and return its exit code: 0, or 2 after one line on stderr that says what is wrong.

    Args:
        arguments: without the program's name; None for those of this process.
        features: add their commands to those of the core.
    """
    arguments = list(sys.argv[1:] if arguments is None else arguments)
    if not arguments or (arguments[0].startswith("-") and arguments[0] not in HELP):
        arguments.insert(0, "serve")
    commands = commands_with(features)
    if arguments[0] in HELP:
        print(top_help(commands))
        return 0
    given = tyro.extras.subcommand_cli_from_dict(
        {name: command.options for name, command in commands.items()},
        prog="lwr-duet",
        args=arguments,
    )
    write_log()
    try:
        return commands[arguments[0]].run(given)
    except DuetError as error:
        print(f"lwr-duet: {error}", file=sys.stderr)
        return 2
