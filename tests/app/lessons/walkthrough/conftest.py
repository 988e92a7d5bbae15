"""Walkthroughs of a small lesson, once and twice."""

from functools import cache
from pathlib import Path

import pytest

from app.lessons.lesson import LessonBook
from app.lessons.walkthrough import Walkthrough
from tests.app.lessons.helpers import book_of, small_walk


@pytest.fixture
def walk(tmp_path: Path) -> Walkthrough:
    return small_walk(tmp_path)


@cache
def two_lessons(folder: Path) -> LessonBook:
    (folder / "two").mkdir(exist_ok=True)
    book_of(folder / "two")
    return book_of(folder / "two", name="02-again.md")
