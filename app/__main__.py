"""Command line: `lwr-duet`, and `python -m app`."""

import sys

from app.runtime.terminal import ending_at_once, run_in_terminal
from controllers.system_libraries import MissingLibrary, naming_missing_library


def main() -> int:
    return run_in_terminal(_command)


def entry() -> None:
    sys.exit(main())


def run_command(arguments: list[str] | None = None) -> int:
    """Exit code of a command of the core or a feature. `arguments`: by default this process's."""
    from app.cli.main import main
    from app.features import FEATURES

    return main(arguments, FEATURES)


def _command() -> int:
    try:
        with naming_missing_library():
            with ending_at_once():
                from app.cli import main  # noqa: F401
            return run_command()
    except MissingLibrary as error:
        print(f"lwr-duet: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    entry()
