"""The command line: reads the arguments and calls the command that they name; `serve` without one."""

import sys
from collections.abc import Callable
from typing import Any, Final

import tyro

from app.cli.bench import Bench, bench
from app.cli.figures import Figures, draw_figures
from app.cli.grade import Grade, LawTest, NewLaw, grade, law_test, new_law
from app.cli.league import League, league
from app.cli.lessons import Handout, Lessons, NewLesson, handout, lessons, new_lesson
from app.cli.robots import Robots, robots
from app.cli.run import RunCommand, simulate
from app.cli.searches import Falsify, Hunt, falsify, hunt
from app.cli.serve import Serve, serve
from app.cli.sweep import Sweep, sweep
from app.runtime.terminal import write_log
from controllers.errors import DuetError

COMMANDS: Final[dict[str, tuple[type, Callable[[Any], int]]]] = {
    "serve": (Serve, serve),
    "run": (RunCommand, simulate),
    "bench": (Bench, bench),
    "figures": (Figures, draw_figures),
    "sweep": (Sweep, sweep),
    "hunt": (Hunt, hunt),
    "falsify": (Falsify, falsify),
    "league": (League, league),
    "robots": (Robots, robots),
    "lessons": (Lessons, lessons),
    "handout": (Handout, handout),
    "new-lesson": (NewLesson, new_lesson),
    "new-law": (NewLaw, new_law),
    "law-test": (LawTest, law_test),
    "grade": (Grade, grade),
}
"""Name of a command → its options and its function, which returns the exit code."""


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit code: 0, or 2 after one line on stderr that says what is wrong."""
    arguments = list(sys.argv[1:] if arguments is None else arguments)
    if not arguments or (arguments[0].startswith("-") and arguments[0] not in ("-h", "--help")):
        arguments.insert(0, "serve")
    command = tyro.extras.subcommand_cli_from_dict(
        {name: options for name, (options, _) in COMMANDS.items()},
        prog="lwr-duet",
        description="Duet: smooth transition between tasks, shown on two KUKA LWR arms (Petrič & Žlajpah, ROBIO 2011). "
        "Without a command it serves the page.",
        args=arguments,
    )
    write_log()
    _, function = COMMANDS[arguments[0]]
    try:
        return function(command)
    except DuetError as error:
        print(f"lwr-duet: {error}", file=sys.stderr)
        return 2
