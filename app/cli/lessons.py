"""`lwr-duet lessons` and `lwr-duet handout`: list the lessons, walk every path through them, or write them as pages to print."""

import json
import sys
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Literal

from app.lessons import FOLDER
from app.runtime.terminal import ending_at_once
from app.settings import LANGUAGES
from controllers.errors import BadSetting
from scenes.files import writable, written


@dataclass(frozen=True)
class Lessons:
    """List the lessons, or with --check walk every path through them: right ones must pass, wrong ones fail for the right reason."""

    check: bool = False
    """Walk every path; exit code 1 if one does not go as declared."""
    only: tuple[str, ...] = ()
    """Names or numbers of lessons; all of them without it."""
    folder: Path = FOLDER
    """Where the lesson files are."""
    out: Path | None = None
    """Save the result of the check to this JSON file."""


def lessons(command: Lessons) -> int:
    """List or check; return the exit code.

    Raises:
        BadSetting: there is no such lesson, or the JSON file cannot be written.
    """
    # These take a second to load.
    with ending_at_once():
        from app.lessons.check import check_lesson, table_text
        from app.lessons.loading import load_lessons
    book = load_lessons(command.folder)
    # Every translation, too: what is wrong with the English file is found each time.
    problems = tuple(dict.fromkeys(p for language in LANGUAGES for p in load_lessons(command.folder, language).problems))
    for problem in problems:
        print(f"left out: {problem}")
    for name in command.only:
        if not any(name in (lesson.id, str(lesson.number)) for lesson in book.lessons):
            book.index(name)
    chosen = tuple(le for le in book.lessons if not command.only or {le.id, str(le.number)} & {*command.only})
    if not command.check:
        for lesson in chosen:
            print(f"{lesson.number:2d}  {lesson.id:24s} {len(lesson.steps)} steps, {lesson.minutes} min  {lesson.title}")
        return 1 if problems else 0
    if command.out is not None and not command.out.absolute().parent.is_dir():
        raise BadSetting(f"out = {command.out}: there is no folder {command.out.absolute().parent}; make it first.")
    walks = [walk for lesson in chosen for walk in check_lesson(book, lesson)]
    print(table_text(walks))
    if command.out is not None:
        data = {"problems": [str(p) for p in problems], "walks": [asdict(walk) for walk in walks]}
        with written(command.out, "out") as new:
            text = json.dumps(data, indent=1, ensure_ascii=False) + "\n"
            # Bytes of a file's name that are no Unicode become escapes of JSON.
            new.write_text(text, encoding="utf-8", errors="backslashreplace", newline="\n")
    return 0 if walks and not problems and all(walk.ok for walk in walks) else 1


@dataclass(frozen=True)
class Handout:
    """Write lessons as pages to print: questions, answers to tick, axes to draw on, and room to write; one HTML file a lesson."""

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
    folder: Path = FOLDER
    """Where the lesson files are."""


def handout(command: Handout) -> int:
    """Write the pages; return the exit code.

    Raises:
        BadSetting: there is no such lesson, a file cannot be written, or a teacher's copy of Moodle's questions is asked for.
    """
    if command.moodle and command.teacher:
        raise BadSetting("Moodle's questions hold the answers already; leave --teacher out.")
    # These take a second to load.
    with ending_at_once():
        from app.export.handout_html import handout_html
        from app.export.moodle_xml import moodle_xml
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
