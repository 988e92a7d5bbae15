"""What `lwr-duet lessons` is asked for; apart from the check, whose libraries take a second to load."""

from dataclasses import dataclass
from pathlib import Path

from app.lessons import FOLDER


@dataclass(frozen=True)
class Lessons:
    """List the lessons, or with --check walk every path through them: right ones must pass, wrong ones fail for the right reason."""

    check: bool = False
    """Walk every path; exit code 1 if one goes otherwise than declared."""
    only: tuple[str, ...] = ()
    """Names or numbers of lessons; all of them without it."""
    folder: Path = FOLDER
    """Where the lesson files are."""
    out: Path | None = None
    """Save the result of the check to this JSON file."""
