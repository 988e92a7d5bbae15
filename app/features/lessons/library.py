"""Lessons of a server, read again when a file changes."""

import logging
import os
import threading
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cache
from itertools import islice
from pathlib import Path
from typing import Any, Final

from app.features.lessons.blocks import quoted_value, read_block
from app.features.lessons.folder import FOLDER
from app.features.lessons.lesson import LAST, NO_LESSONS, Lesson, LessonBook, LessonProblem, Step
from app.features.lessons.loading import load_lessons, problems_of, read_text
from app.features.lessons.markdown import DataBlock, Fault, FaultLog
from app.features.lessons.reference_runs import forget
from app.runtime.throttled_log import ThrottledLog
from app.settings import TRANSLATIONS, Language
from app.text.lesson_text import lesson_html

log = logging.getLogger("duet.lessons")

BELIEFS: Final = FOLDER / "beliefs"
"""Test before the first lesson and after the last."""

PERIOD: Final = 0.5
"""Period of the check for changed files [s]."""

MOST_FILES: Final = 2000

MOST_NAMES: Final = 200

_LIKE: Final = 'like lessons = ["drift", "lambda#tail", "mine/01-nearer.md"]'

_ours = cache(load_lessons)


def notes_of(book: LessonBook) -> dict[str, str]:
    """Teacher's notes (Markdown) by lesson id; outside `Lesson`, so that no student's page has them."""
    notes: dict[str, str] = {}
    for lesson in book.lessons:
        with suppress(Fault):
            notes[lesson.id] = read_text(
                lesson.steps[0].setup.folder / lesson.file.replace(".md", ".notes.md")
            )
    return notes


def _entries_in(text: str, log: FaultLog) -> list[Any]:
    """Unchecked entries; unknown keys go to the log."""
    table = read_block(DataBlock(1, text.splitlines()), "playlist")
    entries = table.any("lessons", [])
    if not isinstance(entries, list) or not entries:
        raise table.fault("lessons", f"a playlist needs a list of names, {_LIKE}.")
    if len(entries) > MOST_NAMES:
        raise table.fault("lessons", f"lessons names {len(entries)}; at most {MOST_NAMES} are shown.")
    log.take(table.close, None)
    return entries


def _asked(lesson: Lesson, last: bool) -> Lesson:
    steps = tuple(replace(step, asked="last" if last else "first") for step in lesson.steps)
    return (
        replace(lesson, id=lesson.id + LAST, title=lesson.again, steps=steps)
        if last
        else replace(lesson, steps=steps)
    )


def _everything(known: Collection[Lesson]) -> Iterator[Lesson]:
    test = [lesson for lesson in known if lesson.again][-1:]
    others = [lesson for lesson in known if not lesson.again]
    return _numbered([(lesson, None) for lesson in (*test, *others, *test)], 1 - len(test))


def _numbered(entries: Sequence[tuple[Lesson, Step | None]], begin: int = 1) -> Iterator[Lesson]:
    """Number the lessons.

    Consecutive steps of a lesson share its minutes; a repeated test has a first and a last round.
    """
    merged: list[tuple[str, Lesson]] = []
    for lesson, step in entries:
        before = [one for name, one in merged if name == lesson.id]
        newest, last = merged[-1] if merged else ("", lesson)
        twice = sum(other.id == lesson.id and part is None for other, part in entries) > 1
        if lesson.again and step is None and twice and not any(one.asked == "last" for one in before):
            made = _asked(lesson, any(one.asked == "first" for one in before))
        elif step is not None and newest == lesson.id and not last.asked and step not in last.steps:
            merged.pop()
            made = replace(last, steps=(*last.steps, step))
        else:
            # File names have no underscore.
            id = f"{lesson.id}_{len(before) + 1}" if before else lesson.id
            made = replace(lesson, id=id, steps=lesson.steps if step is None else (step,))
        merged.append((lesson.id, made))
    whole = {lesson.id: len(lesson.steps) for lesson, _ in entries}
    for number, (name, lesson) in enumerate(merged, begin):
        minutes = max(1, round(lesson.minutes * len(lesson.steps) / whole[name]))
        yield replace(lesson, number=number, minutes=minutes)


class Library:
    """Reads the book, and again after changes; a faulty lesson keeps its last good state.

    Args:
        folder: more lessons, which replace ours of the same name.
        playlist: TOML file with the lessons to show, in order; None for all.
    """

    def __init__(
        self, folder: Path | None = None, playlist: Path | None = None, with_notes: bool = False
    ) -> None:
        self._folder, self._playlist, self._with_notes = folder, playlist, with_notes
        self._good: dict[tuple[Path, Language], LessonBook] = {}
        self._entries: list[Any] = []
        self._ended = threading.Event()
        self._thread: threading.Thread | None = None
        self._read()
        self._seen = self._looked = self._stamps()

    def _read(self) -> None:
        book = self.book_in("en")
        for language in TRANSLATIONS if self._good else ():
            # Ready for the next frame.
            book.in_language(language)
        self.book, self.notes = book, notes_of(book) if self._with_notes else {}

    def book_in(self, language: Language) -> LessonBook:
        """Read the book. Never raises."""
        books = [_ours(BELIEFS, language), _ours(FOLDER, language)]
        if self._folder is not None:
            books.append(self._folder_in(self._folder, language))
        problems = [problem for book in books for problem in book.problems]
        known = {lesson.id: lesson for book in books for lesson in book.lessons}
        lessons = (
            _everything(known.values())
            if self._playlist is None
            else self._listed(self._playlist, known, problems, language)
        )
        return LessonBook(tuple(lessons), tuple(dict.fromkeys(problems)), cache(self.book_in))

    def _folder_in(self, folder: Path, language: Language) -> LessonBook:
        book = self._good[folder, language] = load_lessons(
            folder, language, self._good.get((folder, language), NO_LESSONS)
        )
        return book

    def _listed(
        self, path: Path, known: dict[str, Lesson], problems: list[LessonProblem], language: Language
    ) -> Iterator[Lesson]:
        text, log, chosen = "", FaultLog(), list[tuple[Lesson, Step | None]]()
        try:
            text = read_text(path)
            self._entries = _entries_in(text, log)
        except Fault as fault:
            problems += problems_of(path, fault)
        problems += (LessonProblem(path.name, fault.line, fault.message) for fault in log.found)
        for number, name in enumerate(self._entries, 1):
            try:
                chosen.append(self._entry(path, name, known, problems, language))
            except Fault as fault:
                lines = [
                    i
                    for i, line in enumerate(text.splitlines(), 1)
                    if f'"{name}"' in line or f"'{name}'" in line
                ]
                problems.append(
                    LessonProblem(path.name, lines[0] if lines else 1, f"entry {number}: {fault.message}")
                )
        return _numbered(chosen)

    def _entry(
        self,
        path: Path,
        name: object,
        known: dict[str, Lesson],
        problems: list[LessonProblem],
        language: Language,
    ) -> tuple[Lesson, Step | None]:
        """A lesson, and its step; None for all steps."""
        if not isinstance(name, str) or not name:
            raise Fault(1, f"{quoted_value(name)} is no name of a lesson; write it {_LIKE}.")
        which, mark, part = name.partition("#")
        lesson = known.get(which)
        if which.endswith(".md"):
            file = (path.parent / which).absolute()
            book = self._folder_in(file.parent, language)
            problems += (one for one in book.problems if one.file.startswith(file.stem + "."))
            lesson = next((one for one in book.lessons if one.file == file.name), None)
        if lesson is None:
            remedy = (
                f"name a file beside the playlist, like mine/01-nearer.md, or choose from {', '.join(known)}."
            )
            raise Fault(1, f"there is no lesson {which!r}; {remedy}")
        if not mark:
            return lesson, None
        for number, step in enumerate(lesson.steps, 1):
            if part in (step.id, str(number)):
                return lesson, step
        raise Fault(
            1, f"{which} has no step {part!r}; choose from {', '.join(step.id for step in lesson.steps)}."
        )

    # ---- while files change ------------------------------------------------------------------------------------------------

    def _stamps(self) -> dict[Path, tuple[int, int]]:
        stamps = dict[Path, tuple[int, int]]()
        paths = [self._playlist] if self._playlist is not None else []
        for folder in {folder for folder, _ in self._good}:
            # Lessons, their pictures and recordings.
            below = (Path(place) / name for place, _, names in os.walk(folder) for name in names)
            paths += islice(below, MOST_FILES)
        for path in paths:
            with suppress(OSError):
                stamps[path] = path.stat().st_mtime_ns, path.stat().st_size
        return stamps

    def refresh(self) -> bool:
        """Read all again if files changed, and not since the last call; true if so."""
        before, self._looked = self._looked, self._stamps()
        if not self._looked or self._looked == self._seen or self._looked != before:
            return False
        self._seen = self._looked
        # A picture or a recording may have changed under the same name.
        lesson_html.cache_clear()
        forget()
        self._read()
        return True

    def watch(self, changed: Callable[[], None]) -> None:
        """Watch the files in a thread until `close`; call `changed` after each reading."""

        errors = ThrottledLog(log)

        def look() -> None:
            while not self._ended.wait(PERIOD):
                try:
                    if self.refresh():
                        changed()
                except Exception as error:
                    # The next change may repair it.
                    errors.exception("the lessons could not be read again", error)

        if self._good or self._playlist is not None:
            self._thread = threading.Thread(target=look, name="duet-lessons-watch", daemon=True)
            self._thread.start()

    def close(self) -> None:
        self._ended.set()
        if self._thread is not None:
            self._thread.join()
