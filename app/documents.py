"""Documents for people as pages of their own, printable: the model, a lecture plan, and how a lesson is written."""

import base64
import html
import re
from functools import cache
from pathlib import Path
from typing import Final

from markdown_it import MarkdownIt

from app.page.lesson_text import formula

FOLDER: Final = Path(__file__).parent / "lessons"

DOCUMENTS: Final = {
    "model": ("model.md", "The model"),
    "lecture-plan": ("lecture-plan.md", "A lecture plan"),
    "lessons": ("README.md", "How to write a lesson"),
}
"""Last part of the address → file in `FOLDER`, and what it is called."""

PREFIX: Final = "/documents/"

_CODE: Final = r"(?:^|(?<=\n))(?P<fence>```|~~~).*?\n(?P=fence)|`[^`\n]*`"
_MATH: Final = re.compile(rf"{_CODE}|\$\$(?P<display>.+?)\$\$|\$(?P<inline>[^$\n]+?)\$", re.DOTALL)
_HELD: Final = re.compile("\ue000(\\d+)\ue001")
_TAG: Final = re.compile(r"\\tag\s*\{([^{}]*)\}")
_LINK: Final = re.compile(r'href="([\w-]+\.md)"')
_PICTURE: Final = re.compile(r'src="(pictures/[\w.-]+\.svg)"')

_STYLE: Final = """
:root{color-scheme:light dark;--ink:light-dark(#1f2328,#e6e9ed);--faint:light-dark(#57606a,#9aa6b2);--line:light-dark(#d5dae0,#3a4149)}
body{margin:0;background:light-dark(#fff,#16181c);color:var(--ink);font:16px/1.55 system-ui,sans-serif}
main{max-width:46rem;margin:0 auto;padding:1.5rem 1.25rem 4rem}
nav{border-bottom:1px solid var(--line);padding:.7rem 1.25rem;display:flex;flex-wrap:wrap;gap:.4rem 1.4rem}
a{color:light-dark(#b34700,#ff9a55)}nav [aria-current]{color:var(--ink);font-weight:600;text-decoration:none}
h1{font-size:1.9rem;line-height:1.2}h2{margin-top:2.2rem;border-bottom:1px solid var(--line);padding-bottom:.2rem}
.formula{overflow-x:auto;display:flex;align-items:center;justify-content:center;gap:1.5rem;margin:1rem 0}
.formula .no{color:var(--faint);margin-left:auto}
table{border-collapse:collapse;width:100%;font-size:.95em}
th,td{border-bottom:1px solid var(--line);padding:.35rem .6rem;text-align:left;vertical-align:top}
pre{overflow-x:auto;background:light-dark(#f4f6f8,#20242a);padding:.8rem 1rem;border-radius:6px;font-size:.88em}code{font-size:.92em}
img{max-width:100%}
.lam{color:light-dark(#6f42c1,#bd9bff)}.dm{color:light-dark(#c2540a,#ff8f45)}.v{color:light-dark(#00795a,#3fd0a0)}
.u{color:light-dark(#946200,#f0bd4a)}.w{color:light-dark(#c62828,#ff7a6b)}
@media print{nav{display:none}
main{max-width:none;padding:0}body{font-size:10.5pt}h2{break-after:avoid}
table,pre,.formula{break-inside:avoid}@page{margin:18mm}}
"""


@cache
def document_page(name: str) -> bytes:
    """Return a document as an HTML page; `name` is a key of `DOCUMENTS`."""
    file, title = DOCUMENTS[name]
    body = document_html((FOLDER / file).read_text(encoding="utf-8"))
    links = "".join(
        f'<a href="{key}"{" aria-current=page" if key == name else ""}>{html.escape(called)}</a>'
        for key, (_, called) in DOCUMENTS.items()
    )
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{html.escape(title)} · Duet</title>'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<style>{_STYLE}</style></head><body><nav aria-label="Documents"><a href="../">Duet</a>{links}</nav>'
        f"<main>{body}</main></body></html>"
    ).encode()


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
