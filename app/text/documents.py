"""The documents as printable HTML pages."""

import os
from functools import cache
from pathlib import Path
from typing import Final

from markupsafe import Markup

from app.i18n.catalogue import words_of
from app.i18n.speaking import N_
from app.settings import Language
from app.text.lesson_text import markdown_reader
from app.text.templates import page_of_template
from app.theme import css_variables, symbol_rules

FOLDER: Final = Path(__file__).parents[1]

DOCUMENTS: Final = {
    "page": ("documents/page.md", N_("The page")),
    "model": ("documents/model.md", N_("The model")),
    "class": ("documents/class.md", N_("For a class")),
    "jupyter": ("documents/jupyter.md", N_("In Jupyter")),
    "lecture-plan": ("documents/lecture-plan.md", N_("A lecture plan")),
    "commands": ("documents/commands.md", N_("Without a page")),
    "league": ("documents/league.md", N_("The league")),
    "lessons": ("lessons/README.md", N_("How to write a lesson")),
    "accessibility": ("documents/accessibility.md", N_("Accessibility")),
    "cite": ("documents/cite.md", N_("How to cite, and licences")),
    "code": ("documents/code.md", N_("The code")),
    "recipes": ("documents/recipes.md", N_("Recipes")),
    "examples": ("documents/examples.md", N_("Examples")),
    "decisions": ("documents/decisions.md", N_("Decisions")),
    "changes": ("documents/changes.md", N_("Changes")),
}
"""Last part of the address → file in `FOLDER`, and what it is called."""

PREFIX: Final = "/documents/"

# As a document names them, from either folder.
_READER: Final = markdown_reader(
    {os.path.relpath(file, folder): name for name, (file, _) in DOCUMENTS.items() for folder in ("documents", "lessons")}
)

_STYLE: Final = Path(__file__).with_name("document.css")


def document_page(name: str, language: Language = "en") -> bytes:
    """Return a document as an HTML page. The documents are English; what stands around them is in the reader's language.

    Args:
        name: a key of `DOCUMENTS`.
        language: of the reader.
    """
    words = words_of(language)
    return page_of_template(
        "text/document.html",
        name=name,
        title=words(DOCUMENTS[name][1]),
        lang="en" if words.language == "pseudo" else words.language,
        asked="" if words.language == "en" else f"?lang={words.language}",
        words=words,
        documents=[(key, called) for key, (_, called) in DOCUMENTS.items()],
        sheet=Markup(css_variables() + _STYLE.read_text(encoding="utf-8") + symbol_rules("main")),
        body=document_html((FOLDER / DOCUMENTS[name][0]).read_text(encoding="utf-8")),
    ).encode()


@cache
def document_html(text: str) -> Markup:
    """Return the Markdown of a document as HTML."""
    return Markup(_READER.render(text, {"folder": FOLDER}))
