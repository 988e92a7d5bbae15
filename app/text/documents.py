"""Documents as printable HTML pages."""

import os
from functools import cache
from pathlib import Path
from typing import Final

from markupsafe import Markup

from app.i18n.catalogue import words_of
from app.settings import Language
from app.text.document_list import DOCUMENTS, DocumentFile
from app.text.lesson_text import markdown_reader
from app.text.templates import page_of_template
from app.theme import css_variables, symbol_rules

FOLDER: Final = Path(__file__).parents[1]

PREFIX: Final = "/documents/"

_STYLE: Final = Path(__file__).with_name("document.css")


def document_page(name: str, language: Language = "en") -> bytes:
    """Page of `DOCUMENTS[name]`: the document is English, the page around it in the reader's language."""
    words = words_of(language)
    return page_of_template(
        "text/document.html",
        name=name,
        title=words(DOCUMENTS[name].title),
        lang="en" if words.language == "pseudo" else words.language,
        asked="" if words.language == "en" else f"?lang={words.language}",
        words=words,
        documents=[(key, called) for key, (_, called) in DOCUMENTS.items()],
        sheet=Markup(css_variables() + _STYLE.read_text(encoding="utf-8") + symbol_rules("main")),
        body=document_html(DOCUMENTS[name].file.read_text(encoding="utf-8")),
    ).encode()


def document_html(text: str) -> Markup:
    return _html(text, tuple(DOCUMENTS.items()))


@cache
def _html(text: str, documents: tuple[tuple[str, DocumentFile], ...]) -> Markup:
    folders = {one.file.parent for _, one in documents}
    # As a document names another one, from whatever folder.
    links = {
        Path(os.path.relpath(one.file, folder)).as_posix(): name
        for name, one in documents
        for folder in folders
    }
    return Markup(markdown_reader(links).render(text, {"folder": FOLDER}))
