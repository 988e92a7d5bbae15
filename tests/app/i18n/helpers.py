"""Errors that the page shows in its language."""

from collections.abc import Callable

import pytest

from app.i18n.speaking import set_language, tr
from controllers.errors import DuetError, LazyText
from tests.app.i18n.conftest import untranslated


def refusal(what: Callable[[], object]) -> LazyText:
    with pytest.raises(DuetError) as caught:
        what()
    said = str(caught.value)
    assert isinstance(said, LazyText)
    return said


def assert_said(what: Callable[[], object]) -> None:
    """Check that the error of `what` is translated completely."""
    said = refusal(what)
    set_language("pseudo")
    # User input, and names of settings, lessons and joints, are the same in every language.
    parts = [str(part) for part in leaves(said)]
    shown = tr(said)
    for part in sorted(parts, key=len, reverse=True):
        shown = shown.replace(part, "")
    assert "⟦" in shown and untranslated(shown) == []


def leaves(message: LazyText) -> list[object]:
    """Parts of a message that are not messages themselves."""
    parts = (leaves(part) if isinstance(part, LazyText) else [part] for part in message.parts.values())
    return [leaf for some in parts for leaf in some if str(leaf)]
