"""The lessons in another language."""

from functools import cache
from pathlib import Path
from typing import Final

from app.lessons.lesson import LessonBook
from app.lessons.loading import LANGUAGES, load_lessons
from app.settings import Language

_TRANSLATED: Final = LANGUAGES[1:]


def in_language(book: LessonBook, language: Language) -> LessonBook:
    """Return the same lessons with the texts that lie beside them in another language; what is not translated stays English."""
    folder = next((step.setup.folder for lesson in book.lessons for step in lesson.steps if step.setup.folder), None)
    if folder is None or language not in _TRANSLATED:
        return book
    return _read(folder, language)


@cache
def _read(folder: Path, language: Language) -> LessonBook:
    return load_lessons(folder, next(one for one in _TRANSLATED if one == language))
