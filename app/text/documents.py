"""The documents as printable HTML pages."""

import html
import os
from functools import cache
from pathlib import Path
from typing import Final

from app.i18n.catalogue import words_of
from app.i18n.speaking import N_
from app.settings import Language
from app.text.lesson_text import markdown_reader

FOLDER: Final = Path(__file__).parents[1]

DOCUMENTS: Final = {
    "page": ("documents/page.md", N_("The page")),
    "model": ("documents/model.md", N_("The model")),
    "class": ("documents/class.md", N_("For a class")),
    "jupyter": ("documents/jupyter.md", N_("In Jupyter")),
    "lecture-plan": ("documents/lecture-plan.md", N_("A lecture plan")),
    "commands": ("documents/commands.md", N_("Without a page")),
    "lessons": ("lessons/README.md", N_("How to write a lesson")),
    "code": ("documents/code.md", N_("The code")),
}
"""Last part of the address → file in `FOLDER`, and what it is called."""

PREFIX: Final = "/documents/"

# As a document of `FOLDER / "documents"` names them.
_READER: Final = markdown_reader({os.path.relpath(file, "documents"): name for name, (file, _) in DOCUMENTS.items()})

_STYLE: Final = Path(__file__).with_name("document.css")


def document_page(name: str, language: Language = "en") -> bytes:
    """Return a document as an HTML page. The documents are English; what stands around them is in the reader's language.

    Args:
        name: a key of `DOCUMENTS`.
        language: of the reader.
    """
    words = words_of(language)
    asked = "" if words.language == "en" else f"?lang={words.language}"
    lang = "en" if words.language == "pseudo" else words.language
    links = "".join(
        f'<a href="{key}{asked}"{" aria-current=page" if key == name else ""}>{html.escape(words(called))}</a>'
        for key, (_, called) in DOCUMENTS.items()
    )
    note = f'<p class="note">{html.escape(words(N_("This document is in English.")))}</p>' if asked else ""
    begin = '<main lang="en">' if asked else "<main>"
    return (
        f'<!doctype html><html lang="{lang}"><head><meta charset="utf-8"><title>{html.escape(words(DOCUMENTS[name][1]))} · Duet'
        '</title><meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<style>{_STYLE.read_text(encoding="utf-8")}</style></head><body><nav aria-label="{html.escape(words(N_("Documents")))}">'
        f'<a href="../{asked}">Duet</a>{links}</nav>{note}{begin}{_body(name)}</main></body></html>'
    ).encode()


@cache
def _body(name: str) -> str:
    return document_html((FOLDER / DOCUMENTS[name][0]).read_text(encoding="utf-8"))


def document_html(text: str) -> str:
    """Return the Markdown of a document as HTML."""
    return _READER.render(text, {"folder": FOLDER})
