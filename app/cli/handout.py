"""`lwr-duet handout`: lessons as pages to print, for students or for the teacher."""

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from app.lessons import FOLDER
from app.runtime.output_file import writable, written
from app.runtime.terminal import ending_at_once


@dataclass(frozen=True)
class Handout:
    """Write lessons as pages to print: questions, answers to tick, axes to draw on, and room to write; one HTML file a lesson."""

    lesson: str = ""
    """Name or number of a lesson; all of them without it."""
    lang: Literal["en", "de", "sl"] = "en"
    """In which the pages speak."""
    teacher: bool = False
    """The teacher's copy: right answers, replies, what is measured, the true curves, and the teacher's notes."""
    out: Path = Path("handouts")
    """Folder for the files; made if there is none."""
    folder: Path = FOLDER
    """Where the lesson files are."""


def handout(command: Handout) -> int:
    """Write the pages; return the exit code.

    Raises:
        BadSetting: there is no such lesson, or a file cannot be written.
    """
    # These take a second to load.
    with ending_at_once():
        from app.export.handout_html import handout_html
        from app.i18n.speaking import set_language
        from app.lessons.loading import load_lessons, load_notes
    book = load_lessons(command.folder, command.lang)
    for problem in book.problems:
        print(f"left out: {problem}", file=sys.stderr)
    chosen = [lesson for lesson in book.lessons if command.lesson in ("", lesson.id, str(lesson.number))]
    if not chosen:
        book.index(command.lesson)
    set_language(command.lang)
    notes = load_notes(command.folder) if command.teacher else {}
    with writable(command.out, "out"):
        command.out.mkdir(parents=True, exist_ok=True)
    for lesson in chosen:
        page = handout_html(lesson, notes.get(lesson.id, "") if command.teacher else None)
        kind = "-teacher" if command.teacher else ""
        path = command.out / f"lesson-{lesson.number:02d}-{lesson.id}-{command.lang}{kind}.html"
        with written(path, "out") as new:
            new.write_text(page, encoding="utf-8", newline="\n")
        print(path)
    return 1 if book.problems else 0
