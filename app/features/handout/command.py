"""The command `lwr-duet handout`."""

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from app.features.lessons.commands import LessonFolder, book_of
from app.features.lessons.folder import FOLDER
from app.runtime.terminal import ending_at_once
from app.settings import LANGUAGES
from controllers.errors import BadSetting
from scenes.files import writable, written


@dataclass(frozen=True)
class Handout:
    """Write lessons as pages to print, one HTML file a lesson.

    They have questions, answers to tick, axes to draw on, and room to write."""

    lesson: str = ""
    """Name or number of a lesson; all of them without it."""
    lang: Literal[tuple(LANGUAGES)] = "en"  # type: ignore[valid-type]
    """In which the pages speak."""
    teacher: bool = False
    """The teacher's copy: right answers, replies, what is measured, the true curves, and the teacher's notes."""
    moodle: bool = False
    """Instead, every question with its replies as Moodle XML, to import into a question bank; one file a lesson."""
    out: Path = Path("handouts")
    """Folder for the files; made if there is none."""
    folder: LessonFolder = FOLDER
    """Where the lesson files are."""
    playlist: Path | None = None
    """The lessons that this file names instead, of ours and of the folder."""


def handout(command: Handout) -> int:
    """Write the pages; return the exit code.

    Raises:
        BadSetting: unknown lesson, unwritable file, or a teacher's copy of Moodle's questions.
    """
    if command.moodle and command.teacher:
        raise BadSetting("Moodle's questions hold the answers already; leave --teacher out.")
    # These take a second to load.
    with ending_at_once():
        from app.features.handout.handout_html import handout_html
        from app.features.handout.moodle_xml import moodle_xml
        from app.features.lessons.library import notes_of
        from app.i18n.speaking import set_language
    book = book_of(command.folder, command.playlist, command.lang)
    for problem in book.problems:
        print(f"fault: {problem}", file=sys.stderr)
    if not book.lessons:
        return 1
    chosen = [book.lessons[book.index(command.lesson)]] if command.lesson else book.lessons
    set_language(command.lang)
    notes = notes_of(book) if command.teacher else {}
    with writable(command.out, "out"):
        command.out.mkdir(parents=True, exist_ok=True)
    for lesson in chosen:
        if command.moodle:
            page, kind = moodle_xml(lesson), ".xml"
        else:
            page = handout_html(lesson, notes.get(lesson.id, "") if command.teacher else None).encode()
            kind = "-teacher.html" if command.teacher else ".html"
        path = command.out / f"lesson-{lesson.number:02d}-{lesson.id}-{command.lang}{kind}"
        with written(path, "out") as new:
            new.write_bytes(page)
        print(path)
    return 1 if book.problems else 0
