"""The command line: reads the arguments and calls the command; `serve` without one."""

import sys
from collections.abc import Sequence
from functools import partial

from app.cli.help import HELP, HELP_ALL, print_help, read_arguments, top_help
from app.cli.run import run_with, simulate
from app.cli.serve import brief_serve_with, serve, serve_with
from app.feature import Command, Feature
from app.runtime.terminal import write_log
from controllers.errors import DuetError


def commands_with(features: Sequence[Feature]) -> dict[str, Command]:
    """Commands of the core, then those of the features, the lowest feature first."""
    commands = {
        "serve": Command(
            serve_with(features),
            partial(serve, features=features),
            "show",
            partial(brief_serve_with, features),
        ),
        "run": Command(run_with(features), partial(simulate, features=features), "compute"),
    }
    for feature in reversed(features):
        if feature.commands is not None:
            commands |= feature.commands()
    return commands


def main(arguments: list[str] | None, features: Sequence[Feature]) -> int:
    """Run the command line and return its exit code: 0, or 2 after one line on stderr with the error.

    Args:
        arguments: without the program's name; None for those of this process.
    """
    arguments = list(sys.argv[1:] if arguments is None else arguments)
    if not arguments or (arguments[0].startswith("-") and arguments[0] not in HELP):
        arguments.insert(0, "serve")
    commands = commands_with(features)
    if arguments[0] in HELP:
        print(top_help(commands))
        return 0
    if asked := {*HELP, HELP_ALL}.intersection(arguments):
        if arguments[0] in commands:
            print_help(commands, arguments[0], is_all=HELP_ALL in asked)
        # Help of an unknown command is an error that names the known ones.
        arguments = [one for one in arguments if one not in asked]
    given = read_arguments(commands, arguments)
    write_log()
    try:
        return commands[arguments[0]].run(given)
    except DuetError as error:
        print(f"lwr-duet: {error}", file=sys.stderr)
        return 2
