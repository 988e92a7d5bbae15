"""`lwr-duet`, and `python -m app`."""

import sys

from app.runtime.terminal import ending_at_once, run_in_terminal


def main() -> int:
    """Run the command line as a process of its own; return the exit code."""
    return run_in_terminal(_command)


def entry() -> None:
    """Run as the installed command `lwr-duet`."""
    sys.exit(main())


def _command() -> int:
    with ending_at_once():
        from app.cli import main as command_line
    return command_line.main()


if __name__ == "__main__":
    entry()
