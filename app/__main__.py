"""`lwr-duet`, and `python -m app`."""

import sys

from app.runtime.terminal import ending_at_once, run_in_terminal
from controllers.system_libraries import MissingLibrary, naming_missing_library


def entry() -> None:
    """Run as the installed command `lwr-duet`."""
    sys.exit(run_in_terminal(_command))


def _command() -> int:
    try:
        with naming_missing_library():
            with ending_at_once():
                from app.cli.main import main
            return main()
    except MissingLibrary as error:
        print(f"lwr-duet: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    entry()
