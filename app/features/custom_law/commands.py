"""`lwr-duet new-law` and `law-test`."""

import os
import shlex
from dataclasses import dataclass
from pathlib import Path

import tyro

from app.runtime.terminal import ending_at_once
from controllers.errors import BadSetting
from scenes.files import replacing


@dataclass(frozen=True)
class NewLaw:
    """Write a file with a law of your own: the paper's, to begin with."""

    path: tyro.conf.Positional[Path]
    """Where to, such as my_law.py."""


@dataclass(frozen=True)
class LawTest:
    """Put a law of your own through six tests, and say why it fails."""

    path: tyro.conf.Positional[Path]
    """The file, such as my_law.py."""


def new_law(command: NewLaw) -> int:
    """Write the file; return the exit code.

    Raises:
        BadSetting: the file exists, or cannot be written.
    """
    from app.features.custom_law.edited_file import first_text

    path = command.path
    if os.path.lexists(path):
        raise BadSetting(f"{path} is there already and is left alone; give another name.")
    try:
        with replacing(path) as new:
            new.write_text(first_text(path), encoding="utf-8", newline="\n")
    except OSError as error:
        raise BadSetting(
            f"{path}: cannot be written ({error.strerror}); give a name in a folder that exists."
        ) from None
    file = shlex.quote(str(path))
    print(f"{path} holds the paper's law. Next: lwr-duet law-test {file}, lwr-duet serve --law-file {file}")
    return 0


def law_test(command: LawTest) -> int:
    """Print the tests; return the exit code, 0 if all are passed.

    Raises:
        BadInputFile: the file cannot be read.
    """
    with ending_at_once():
        from app.features.custom_law.examination import examine, verdict_table

    verdicts = list(examine(command.path))
    print(verdict_table(command.path, verdicts))
    return 0 if all(verdict.passed for verdict in verdicts) else 1
