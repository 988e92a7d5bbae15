"""`lwr-duet`, and `python -m app`."""

import sys

from app.runtime.terminal import ending_at_once, run_in_terminal


def entry() -> None:
    """Run as the installed command `lwr-duet`."""
    sys.exit(run_in_terminal(_command))


def _command() -> int:
    with ending_at_once():
        from app.cli.main import main
    return main()


if __name__ == "__main__":
    entry()
