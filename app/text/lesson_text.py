"""Markdown as HTML, with tables, LaTeX formulas, and pictures on their own lines. Raw HTML is escaped; links
lead only to http, https or a document.
"""

import html
import logging
import re
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any, Final

from markdown_it import MarkdownIt
from markdown_it.common.utils import escapeHtml
from markdown_it.ruler import RuleOptionsType
from markdown_it.rules_block import StateBlock
from markdown_it.rules_core import StateCore
from markdown_it.rules_inline import StateInline
from markupsafe import Markup

from app.text.formula import display_formula, formula, plain_formula
from app.text.picture import PICTURE, NoPicture, picture_html
from app.text.units import unbroken

log = logging.getLogger("duet.lessons")

_INLINE: Final = re.compile(r"\$\$(.+?)\$\$|\$([^$\n]+?)\$", re.DOTALL)
_SPANS: Final = re.compile(
    r"^ {0,3}(?P<fence>`{3,}|~{3,}).*?(?:^ {0,3}(?P=fence)|\Z)|(?P<code>`+)[^`]+(?P=code)|\\\$"
    r"|(?P<formula>(?P<dollars>\${1,2})(?:[^$\n]|\n(?!\s*\n))+?(?P=dollars))",
    re.DOTALL | re.MULTILINE,
)

_BLOCK: Final = re.compile(r"\$\$(.+?)\$\$[ \t]*$", re.DOTALL | re.MULTILINE)


def markdown_reader(pages: Mapping[str, str] | None = None) -> MarkdownIt:
    """Parser and renderer. `env["folder"]` has the pictures; without it their descriptions are shown.
    `pages`: linkable file → address of its page.
    """
    known = dict(pages or {})
    reader = MarkdownIt("commonmark", {"html": False}).enable("table").disable("image")
    normalize = reader.normalizeLink
    reader.normalizeLink = lambda url: known.get(url) or normalize(url)
    reader.validateLink = lambda url: url in known.values() or url.startswith(("http://", "https://"))
    # Both may directly follow a line of text and end its paragraph.
    ends: RuleOptionsType = {"alt": ["paragraph", "reference", "blockquote", "list"]}
    reader.block.ruler.before("paragraph", "formula_block", _formula_block, ends)
    reader.block.ruler.before("paragraph", "picture", _picture, ends)
    reader.inline.ruler.before("escape", "formula", _formula)
    reader.core.ruler.before("block", "formula_lines", _join_formulas)
    for name, rule in _RENDERED.items():
        reader.add_render_rule(name, rule)
    # The rules compile on first use, where two threads would disturb each other.
    reader.render("x")
    return reader


def _join_formulas(state: StateCore) -> None:
    """Join a formula's lines: one that begins with a plus would become a list."""
    state.src = _SPANS.sub(
        lambda span: re.sub(r"\s*\n\s*", " ", span[0]) if span["formula"] else span[0], state.src
    )


def left_dollar(text: str) -> int | None:
    """0-based line of a dollar outside formulas."""
    rest = _SPANS.sub(lambda span: "\n" * span[0].count("\n"), text)
    return rest[: rest.index("$")].count("\n") if "$" in rest else None


def _formula(state: StateInline, silent: bool) -> bool:
    found = _INLINE.match(state.src, state.pos, state.posMax)
    if found is None:
        return False
    if not silent:
        token = state.push("formula" if found[1] is None else "formula_display", "", 0)
        token.content = found[2] if found[1] is None else found[1]
    state.pos = found.end()
    return True


def _formula_block(state: StateBlock, start: int, end: int, silent: bool) -> bool:
    begin = state.bMarks[start] + state.tShift[start]
    found = _BLOCK.match(state.src, begin, state.eMarks[end - 1])
    if found is None:
        return False
    if not silent:
        state.push("formula_block", "", 0).content = found[1]
        state.line = start + found[0].count("\n") + 1
    return True


def _picture(state: StateBlock, start: int, _end: int, silent: bool) -> bool:
    found = PICTURE.fullmatch(state.src[state.bMarks[start] + state.tShift[start] : state.eMarks[start]])
    if found is None:
        return False
    if not silent:
        token = state.push("picture", "", 0)
        token.content, token.info = found[1], found[2]
        state.line = start + 1
    return True


def _picture_html(words: str, name: str, folder: Path | None) -> str:
    try:
        if folder is None:
            raise NoPicture("there is no folder")
        return picture_html(folder, name, words)
    except NoPicture as problem:
        log.warning("a picture cannot be shown: %s", problem)
        return f"<p>{html.escape(words)}</p>"


def _link_open(renderer: Any, tokens: Any, at: int, options: Any, env: Any) -> str:
    if tokens[at].attrs["href"].startswith("http"):
        tokens[at].attrs |= {"target": "_blank", "rel": "noopener"}
    return renderer.renderToken(tokens, at, options, env)


_RENDERED: Final = {
    "formula": lambda _, tokens, at, *__: formula(tokens[at].content, True),
    "formula_display": lambda _, tokens, at, *__: (
        f'<span class="duet-formula">{display_formula(tokens[at].content)}</span>'
    ),
    "formula_block": lambda _, tokens, at, *__: (
        f'<div class="duet-formula">{display_formula(tokens[at].content)}</div>'
    ),
    "picture": lambda _, tokens, at, __, env: _picture_html(
        tokens[at].content, tokens[at].info, env.get("folder")
    ),
    "link_open": _link_open,
    # Code and formulas stay as they are.
    "text": lambda _, tokens, at, *__: escapeHtml(unbroken(tokens[at].content)),
}

_READER: Final = markdown_reader()


@lru_cache(maxsize=256)
def lesson_html(text: str, folder: Path | None = None) -> Markup:
    return Markup(_READER.render(text, {"folder": folder}))


@lru_cache(maxsize=256)
def inline_html(text: str) -> Markup:
    return Markup(_READER.renderInline(text))


def plain(text: str) -> str:
    """A Markdown line as plain text."""
    tokens = _READER.parseInline(text)[0].children or []
    return "".join(
        " "
        if token.type == "softbreak"
        else plain_formula(token.content)
        if token.type == "formula"
        else token.content
        for token in tokens
    )
