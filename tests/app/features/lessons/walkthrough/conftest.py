"""A walkthrough of a small lesson."""

from pathlib import Path

import pytest

from app.features.lessons.walkthrough import Walkthrough
from tests.app.features.lessons.helpers import book_of


@pytest.fixture
def walk(tmp_path: Path) -> Walkthrough:
    book = book_of(tmp_path)
    assert not book.problems, book.problems[0]
    return Walkthrough(book)
