"""Documents for people as pages of their own, printable: the model, a lecture plan, and how a lesson is written."""

import base64
import html
import re
from functools import cache
from pathlib import Path
from typing import Final

from markdown_it import MarkdownIt

from app.i18n.catalogue import words_of
from app.i18n.speaking import N_
from app.settings import Language
from app.text.lesson_text import formula

FOLDER: Final = Path(__file__).parents[1] / "lessons"

DOCUMENTS: Final = {
    "model": ("model.md", N_("The model")),
    "lecture-plan": ("lecture-plan.md", N_("A lecture plan")),
    "lessons": ("README.md", N_("How to write a lesson")),
}
"""Last part of the address → file in `FOLDER`, and what it is called."""

PREFIX: Final = "/documents/"

_CODE: Final = r"(?:^|(?<=\n))(?P<fence>```|~~~).*?\n(?P=fence)|`[^`\n]*`"
_MATH: Final = re.compile(rf"{_CODE}|\$\$(?P<display>.+?)\$\$|\$(?P<inline>[^$\n]+?)\$", re.DOTALL)
_HELD: Final = re.compile("\ue000(\\d+)\ue001")
_TAG: Final = re.compile(r"\\tag\s*\{([^{}]*)\}")
_LINK: Final = re.compile(r'href="([\w-]+\.md)"')
_PICTURE: Final = re.compile(r'src="(pictures/[\w.-]+\.svg)"')

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
    """Return Markdown with tables and LaTeX as HTML; whatever is HTML in it is shown as it was written."""
    held: list[str] = []

    def hold(found: re.Match[str]) -> str:
        if found["display"] is not None:
            number = ", ".join(_TAG.findall(found["display"]))
            shown = f'<span class="no">({html.escape(number)})</span>' if number else ""
            lines = " ".join(_TAG.sub("", found["display"]).split())
            held.append(f'<span class="formula">{formula(lines, False)}{shown}</span>')
        elif found["inline"] is not None:
            held.append(formula(found["inline"], True))
        else:
            return found[0]
        return f"\ue000{len(held) - 1}\ue001"

    reader = MarkdownIt("commonmark", {"html": False}).enable("table")
    made = reader.render(_MATH.sub(hold, text))
    made = _LINK.sub(_to_page, _PICTURE.sub(_inside, made))
    return _HELD.sub(lambda m: held[int(m[1])], made)


def _to_page(found: re.Match[str]) -> str:
    name = next((key for key, (file, _) in DOCUMENTS.items() if file == found[1]), None)
    return found[0] if name is None else f'href="{name}"'


def _inside(found: re.Match[str]) -> str:
    data = base64.b64encode((FOLDER / found[1]).read_bytes()).decode()
    return f'src="data:image/svg+xml;base64,{data}"'
