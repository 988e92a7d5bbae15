"""The documents as printable HTML pages: the model, a lecture plan, and how to write a lesson."""

import html
from functools import cache
from pathlib import Path
from typing import Final

from app.i18n.catalogue import words_of
from app.i18n.speaking import N_
from app.settings import Language
from app.text.lesson_text import markdown_reader

FOLDER: Final = Path(__file__).parents[1] / "lessons"

DOCUMENTS: Final = {
    "model": ("model.md", N_("The model")),
    "lecture-plan": ("lecture-plan.md", N_("A lecture plan")),
    "lessons": ("README.md", N_("How to write a lesson")),
}
"""Last part of the address → file in `FOLDER`, and what it is called."""

PREFIX: Final = "/documents/"

_READER: Final = markdown_reader({file: name for name, (file, _) in DOCUMENTS.items()})

_STYLE: Final = """
:root{color-scheme:light dark;--ink:light-dark(#1f2328,#e6e9ed);--faint:light-dark(#57606a,#9aa6b2);--line:light-dark(#d5dae0,#3a4149)}
body{margin:0;background:light-dark(#fff,#16181c);color:var(--ink);font:16px/1.55 system-ui,sans-serif}
main{max-width:46rem;margin:0 auto;padding:1.5rem 1.25rem 4rem}
nav{border-bottom:1px solid var(--line);padding:.7rem 1.25rem;display:flex;flex-wrap:wrap;gap:.4rem 1.4rem}
a{color:light-dark(#b34700,#ff9a55)}nav [aria-current]{color:var(--ink);font-weight:600;text-decoration:none}
h1{font-size:1.9rem;line-height:1.2}h2{margin-top:2.2rem;border-bottom:1px solid var(--line);padding-bottom:.2rem}
.duet-formula{overflow-x:auto;display:flex;align-items:center;justify-content:center;gap:1.5rem;margin:1rem 0}
.duet-formula .no{color:var(--faint);margin-left:auto}
table{border-collapse:collapse;width:100%;font-size:.95em}
th,td{border-bottom:1px solid var(--line);padding:.35rem .6rem;text-align:left;vertical-align:top}
pre{overflow-x:auto;background:light-dark(#f4f6f8,#20242a);padding:.8rem 1rem;border-radius:6px;font-size:.88em}code{font-size:.92em}
img{max-width:100%}
.note{max-width:46rem;margin:1rem auto 0;padding:0 1.25rem;color:var(--faint);font-style:italic}
.lam{color:light-dark(#6f42c1,#bd9bff)}.dm{color:light-dark(#c2540a,#ff8f45)}.v{color:light-dark(#00795a,#3fd0a0)}
.u{color:light-dark(#946200,#f0bd4a)}.w{color:light-dark(#c62828,#ff7a6b)}
@media print{nav,.note{display:none}
main{max-width:none;padding:0}body{font-size:10.5pt}h2{break-after:avoid}
table,pre,.duet-formula{break-inside:avoid}@page{margin:18mm}}
"""


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
        f'<style>{_STYLE}</style></head><body><nav aria-label="{html.escape(words(N_("Documents")))}">'
        f'<a href="../{asked}">Duet</a>{links}</nav>{note}{begin}{_body(name)}</main></body></html>'
    ).encode()


@cache
def _body(name: str) -> str:
    return document_html((FOLDER / DOCUMENTS[name][0]).read_text(encoding="utf-8"))


def document_html(text: str) -> str:
    """Return the Markdown of a document as HTML."""
    return _READER.render(text, {"folder": FOLDER})
