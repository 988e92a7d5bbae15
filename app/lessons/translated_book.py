"""The lessons in another language."""

from functools import cache

from app.lessons.lesson import LessonBook
from app.lessons.loading import LANGUAGES, load_lessons
from app.settings import Language

_read = cache(load_lessons)


def in_language(book: LessonBook, language: Language) -> LessonBook:
    """Return the same lessons with the texts that lie beside them in another language; what is not translated stays English."""
    folder = next((step.setup.folder for lesson in book.lessons for step in lesson.steps if step.setup.folder), None)
    return book if folder is None or language not in LANGUAGES[1:] else _read(folder, language)
