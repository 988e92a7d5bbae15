"""A page for a reader of German."""

from collections.abc import Iterator

import pytest

from app.i18n.speaking import set_language


@pytest.fixture
def german() -> Iterator[None]:
    """What is made in this thread meanwhile is in German."""
    set_language("de")
    yield
    set_language("en")
