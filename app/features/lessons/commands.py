"""`lwr-duet lessons` and `new-lesson`."""

import json
import os
import re
import shlex
import sys
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from app.features.lessons.folder import FOLDER
from app.runtime.terminal import ending_at_once
from app.settings import LANGUAGES, Language
from controllers.errors import BadSetting
from scenes.files import check_writable, writable, written

if TYPE_CHECKING:
    from app.features.lessons.lesson import LessonBook, LessonProblem


LessonFolder = Annotated[Path, tyro.conf.arg(help_behavior_hint="(default: the lessons of Duet)")]
"""Its help names no path of the computer."""


@dataclass(frozen=True)
class Lessons:
    """List the lessons, or check them by walking every path.

    With --check, right paths must pass, and wrong ones fail for the right reason."""

    check: bool = False
    """Walk every path; exit code 1 if one does not go as declared."""
    only: tuple[str, ...] = ()
    """Names or numbers of lessons; all of them without it."""
    folder: LessonFolder = FOLDER
    """Where the lesson files are."""
    playlist: Path | None = None
    """The lessons that this file names instead, of ours and of the folder; see app/features/lessons/files/README.md."""
    out: Path | None = None
    """Save the result of the check to this JSON file."""


def lessons(command: Lessons) -> int:
    """Run the command; return the exit code.

    Raises:
        BadSetting: unknown lesson, nothing to check, or the JSON file cannot be written.
    """
    if command.out is not None and not command.check:
        raise BadSetting("--out saves what the check finds; add --check, or leave out --out.")
    # Slow imports (a second).
    with ending_at_once():
        from app.features.lessons.check import check_lesson, table_text
    book = book_of(command.folder, command.playlist)
    # Check the translations, too: faults of the English file are found with each of them.
    problems = tuple(
        dict.fromkeys(problem for language in LANGUAGES for problem in book.in_language(language).problems)
    )
    for problem in problems:
        print(f"fault: {problem}")
    chosen = book.lessons
    if command.only and book.lessons:
        chosen = tuple(book.lessons[i] for i in sorted({*map(book.index, command.only)}))
    if not command.check:
        for lesson in chosen:
            steps = f"{len(lesson.steps)} step{'s' if len(lesson.steps) > 1 else ''}"
            print(f"{lesson.number:2d}  {lesson.id:24s} {steps}, {lesson.minutes} min  {lesson.title}")
        return _last_line(problems, 0)
    if command.out is not None:
        check_writable(command.out, "out")
    walks = [walk for lesson in chosen for walk in check_lesson(book, lesson)]
    print(table_text(walks))
    if command.out is not None:
        data = {"problems": [str(p) for p in problems], "walks": [asdict(walk) for walk in walks]}
        with written(command.out, "out") as new:
            text = json.dumps(data, indent=1, ensure_ascii=False) + "\n"
            # Bytes of a file name that are not Unicode become escapes of JSON.
            new.write_text(text, encoding="utf-8", errors="backslashreplace", newline="\n")
    failed = sum(not walk.ok for walk in walks)
    return _last_line(problems, failed) if walks or problems else 1


def book_of(folder: Path, playlist: Path | None, language: Language = "en") -> "LessonBook":
    """Lessons of a playlist or a folder; ours includes its test.

    Raises:
        BadSetting: no such playlist.
    """
    from app.features.lessons.library import Library
    from app.features.lessons.loading import load_lessons

    if playlist is not None and not os.path.isfile(playlist):
        raise BadSetting(
            f"playlist = {playlist}: there is no such file; see app/features/lessons/files/README.md."
        )
    if playlist is None and folder != FOLDER:
        return load_lessons(folder, language)
    return Library(None if folder == FOLDER else folder, playlist).book.in_language(language)


def _last_line(problems: "tuple[LessonProblem, ...]", failed: int) -> int:
    """Print the summary; return the exit code."""
    if not (problems or failed):
        return 0
    parts = (
        [f"{len(problems)} faults in {len({problem.file for problem in problems})} files"] if problems else []
    )
    parts += [f"{failed} paths do not go as declared"] if failed else []
    text = f"NOT RIGHT: {'; '.join(parts)}."
    print(f"\x1b[31m{text}\x1b[0m" if sys.stdout.isatty() and "NO_COLOR" not in os.environ else text)
    return 1


@dataclass(frozen=True)
class NewLesson:
    """Write a small lesson to begin with.

    It passes `lessons --check`, and `serve --lessons` shows it while you change it."""

    path: tyro.conf.Positional[Path]
    """A file like my-lessons/01-nearer.md."""


def new_lesson(command: NewLesson) -> int:
    """Write the file; return the exit code.

    Raises:
        BadSetting: the file exists, has another kind of name, or cannot be written.
    """
    path = command.path
    if not re.fullmatch(r"\d{1,3}-[a-z0-9-]+\.md", path.name):
        raise BadSetting(f"{path}: the name of a lesson is like 01-nearer.md.")
    if os.path.lexists(path):
        raise BadSetting(f"{path}: there is a file already; name another one.")
    (text,) = re.findall(
        r"````markdown\n(.*?)````\n", (FOLDER / "README.md").read_text(encoding="utf-8"), flags=re.DOTALL
    )
    with writable(path, "the lesson"):
        path.parent.mkdir(parents=True, exist_ok=True)
    with written(path, "the lesson") as new:
        new.write_text(text, encoding="utf-8", newline="\n")
    folder = shlex.quote(str(path.parent))
    print(f"{path}\nlwr-duet lessons --check --folder {folder}\nlwr-duet serve --lessons {folder}")
    return 0
