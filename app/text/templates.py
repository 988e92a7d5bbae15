"""HTML by `element` for a single tag, and by Jinja2 templates beside their code. All text except `Markup` is
escaped.
"""

import re
from collections.abc import Iterator
from functools import cache
from typing import Any, Final

from jinja2 import Environment, PackageLoader, StrictUndefined
from jinja2.ext import Extension
from jinja2.lexer import Token, TokenStream
from markupsafe import Markup, escape

from app.i18n.speaking import decimal, tr
from app.text.lesson_text import inline_html, lesson_html
from app.text.units import unbroken

_BREAK: Final = re.compile(r"(?:\A|(?<=>))\s*\n\s*|\s*\n\s*(?=<|\Z)")
"""A line break beside a tag of HTML or of the template, with indentation."""

_LOWERED: Final = re.compile(
    r"`(?P<code>[^`\n]+)`|(?<!\w)(?P<symbol>[^\W\d_])_(?P<index>[A-Za-z0-9]{1,5})(?!\w)"
)
"""Code between backticks, also in HTML, or a symbol with an index."""


class _JoinedLines(Extension):
    """Only spaces within a line separate tags."""

    def filter_stream(self, stream: TokenStream) -> Iterator[Token]:
        for token in stream:
            yield Token(token.lineno, "data", _BREAK.sub("", token.value)) if token.type == "data" else token


def tr_html(text: str, /, **parts: object) -> Markup:
    """A text with tags in the current language; filled-in values are escaped."""
    filled = tr(
        text, **{name: part if isinstance(part, int) else escape(part) for name, part in parts.items()}
    )
    return Markup(unbroken(filled))


def lowered(text: str) -> Markup:
    """Subscripts and code as HTML: d_m → d<sub>m</sub>, `d_m` → <code>d_m</code>."""
    return Markup(_LOWERED.sub(_lowered_html, str(escape(text))))


def _lowered_html(found: re.Match[str]) -> str:
    return (
        f"<code>{found['code']}</code>" if found["code"] else f"{found['symbol']}<sub>{found['index']}</sub>"
    )


def _finalized(value: object) -> object:
    return unbroken(value) if isinstance(value, str) and not isinstance(value, Markup) else value


@cache
def _environment() -> Environment:
    made = Environment(
        loader=PackageLoader("app", ""),
        autoescape=True,
        undefined=StrictUndefined,
        extensions=(_JoinedLines,),
        finalize=_finalized,
        auto_reload=False,
    )
    made.globals |= {"tr": tr, "tr_html": tr_html, "decimal": decimal}
    made.globals |= {"inline_html": inline_html, "lesson_html": lesson_html, "lowered": lowered}
    return made


@cache
def macros(file: str) -> Any:
    """Macros as functions that return `Markup`. `file`: below `app/`."""
    return _environment().get_template(file).module


def page_of_template(file: str, **values: object) -> str:
    """A filled template.

    Raises:
        UndefinedError: the template names a missing value.
    """
    return _environment().get_template(file).render(values)


def element(tag: str, text: str = "", *children: str, **attributes: str) -> Markup:
    """A single HTML element.

    Args:
        text: escaped, unless it is `Markup`.
        children: HTML after the text.
        attributes: escaped; a name's final underscore is dropped (`class_`), others become hyphens.
    """
    given = "".join(
        f' {name.rstrip("_").replace("_", "-")}="{escape(value)}"' for name, value in attributes.items()
    )
    return Markup(f"<{tag}{given}>{unbroken(escape(text))}{''.join(children)}</{tag}>")
