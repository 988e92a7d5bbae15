"""A lesson's Markdown as HTML: paragraphs, lists, emphasis, code, pictures, and LaTeX drawn as SVG with its symbols in their colours.

All that a file says is escaped; nothing of it reaches the page as HTML of its own.
"""

import html
import logging
import re
from functools import cache, lru_cache
from pathlib import Path
from typing import Final

from ziamath import zmath
from ziamath.config import config

from app.text.picture import PICTURE, NoPicture, read_picture
from app.theme import PALETTES

log = logging.getLogger("duet.lessons")

SIZE: Final = 16.0
"""Of a formula's letters [CSS px]."""

_LIGHT: Final = PALETTES["light"]

_SYMBOLS: Final = {
    "lam": (_LIGHT.activation, r"\\lambda(?![A-Za-z])"),
    "dm": (_LIGHT.critical, r"d_m(?![A-Za-z])|d_\{m\}"),
    "v": (_LIGHT.velocity, r"(?<![\\A-Za-z_^])v(?![A-Za-z])"),
    "u": (_LIGHT.pull, r"(?<![\\A-Za-z_^])u(?![A-Za-z])"),
    "w": (_LIGHT.approach, r"(?<![\\A-Za-z_^])w(?![A-Za-z])"),
}
"""Class of the style sheet → colour that stands for it while a formula is drawn, and how the symbol is written."""

_WORDS: Final = re.compile(r"\\(?:text|mathrm|operatorname|mathbb|mathbf)\s*\{[^{}]*\}")
_DISPLAY: Final = re.compile(r"\$\$(.+?)\$\$", re.DOTALL)
_TAG: Final = re.compile(r"\\tag\s*\{([^{}]*)\}")
_ENTRY: Final = re.compile(r"^\s{0,3}(?:[-*]|(\d+)[.)])\s+(.*)$")
_INLINE: Final = re.compile(r"\$([^$\n]+?)\$|`([^`\n]+)`|\*\*(.+?)\*\*|\*(.+?)\*", re.DOTALL)


@lru_cache(maxsize=256)
def lesson_html(text: str, folder: Path | None = None) -> str:
    """Return a text of a lesson as HTML.

    Args:
        text: Markdown.
        folder: where its pictures are; None for no pictures.
    """
    parts: list[str] = []
    for i, piece in enumerate(_DISPLAY.split(text)):
        parts.append(_display(piece) if i % 2 else _blocks(piece, folder))
    return "".join(parts)


def _blocks(text: str, folder: Path | None) -> str:
    made: list[str] = []
    # A picture ends the paragraph before it.
    for block in re.split(r"\n\s*\n", PICTURE.sub(r"\n\g<0>\n", text).strip("\n")):
        lines = block.strip().splitlines()
        if not lines:
            continue
        picture = PICTURE.fullmatch(block.strip())
        if lines[0].startswith("```"):
            code = "\n".join(line for line in lines if not line.startswith("```"))
            made.append(f"<pre>{html.escape(code)}</pre>")
        elif picture is not None:
            made.append(_picture(picture[1], picture[2], folder))
        elif _ENTRY.match(lines[0]):
            made.append(_list(lines))
        else:
            made.append(f"<p>{inline_html(' '.join(line.strip() for line in lines))}</p>")
    return "".join(made)


def _list(lines: list[str]) -> str:
    entries: list[str] = []
    numbered = bool((_ENTRY.match(lines[0]) or [None, None])[1])
    for line in lines:
        found = _ENTRY.match(line)
        if found is not None:
            entries.append(found[2])
        else:
            entries[-1] += " " + line.strip()
    kind = "ol" if numbered else "ul"
    return f"<{kind}>" + "".join(f"<li>{inline_html(entry)}</li>" for entry in entries) + f"</{kind}>"


def _picture(words: str, name: str, folder: Path | None) -> str:
    said = html.escape(words)
    try:
        if folder is None:
            raise NoPicture("there is no folder")
        picture = read_picture(folder, name)
    except NoPicture as problem:
        log.warning("a picture cannot be shown: %s", problem)
        return f"<p>{said}</p>"
    if picture.svg:
        return picture.svg.replace("<svg ", f'<svg class="picture" role="img" aria-label="{said}" ', 1)
    return f'<img alt="{said}" src="{picture.address}">'


def inline_html(text: str) -> str:
    """Return a line of Markdown as HTML: formulas, code and emphasis."""
    made, end = [], 0
    for found in _INLINE.finditer(text):
        made.append(html.escape(text[end : found.start()]))
        end = found.end()
        if found[1] is not None:
            made.append(formula(found[1], True))
        elif found[2] is not None:
            made.append(f"<code>{html.escape(found[2])}</code>")
        else:
            tag, inner = ("strong", found[3]) if found[3] is not None else ("em", found[4])
            made.append(f"<{tag}>{inline_html(inner)}</{tag}>")
    return "".join(made) + html.escape(text[end:])


def _display(tex: str) -> str:
    number = ", ".join(tag for tag in _TAG.findall(tex))
    lines = _TAG.sub("", tex).strip()
    shown = f'<span class="no">({html.escape(number)})</span>' if number else ""
    return f'<div class="duet-formula">{formula(" ".join(lines.split()), False)}{shown}</div>'


@cache
def formula(tex: str, inline: bool) -> str:
    """Return LaTeX as SVG with a name for whoever cannot see it; what cannot be drawn is shown as it was written."""
    # Shared <symbol> ids of several formulas on one page would collide.
    config.svg2 = False
    for source in (_coloured(tex), tex):
        try:
            drawn = zmath.Latex(source, size=SIZE, inline=inline)
            svg, below = drawn.svg(), drawn.getyofst()
            break
        except Exception:
            # Whatever a formula does to the library, the lesson goes on.
            continue
    else:
        log.warning("a formula cannot be drawn: %s", tex[:80])
        return f"<code>{html.escape(tex)}</code>"
    for name, (colour, _) in _SYMBOLS.items():
        svg = svg.replace(f'fill="{colour}"', f'class="{name}" fill="currentColor"')
    svg = svg.replace('fill="black"', 'fill="currentColor"')
    place = f' style="vertical-align:{below:.2f}px"' if inline else ""
    return svg.replace("<svg ", f'<svg role="img" aria-label="{html.escape(spoken(tex))}" fill="currentColor"{place} ', 1)


def _coloured(tex: str) -> str:
    """Return LaTeX with the symbols in their colours; words in it are left alone."""
    pieces, end = [], 0
    for words in _WORDS.finditer(tex):
        pieces += [_colour(tex[end : words.start()]), words[0]]
        end = words.end()
    return "".join([*pieces, _colour(tex[end:])])


def _colour(tex: str) -> str:
    whole = "|".join(f"(?P<{name}>{pattern})" for name, (_, pattern) in _SYMBOLS.items())
    return re.sub(whole, lambda m: rf"{{\textcolor{{{_SYMBOLS[str(m.lastgroup)][0]}}}{{{m[0]}}}}}", tex)


_PLAIN: Final = (
    (r"\\(?:text|mathrm|operatorname|mathbb|mathbf)\s*\{([^{}]*)\}", r"\1"),
    (r"\\frac\s*\{([^{}]*)\}\s*\{([^{}]*)\}", r"\1/\2"),
    (r"\\dot\s*\{?\\?([a-z])\}?", "\\1\u0307"),
    (r"\\ddot\s*\{?([a-z])\}?", "\\1\u0308"),
    (r"\\lambda", "λ"),
    (r"\\gamma", "γ"),
    (r"\\varphi", "φ"),
    (r"\\Delta\s*", "Δ"),
    (r"\\cdot\s*", "·"),
    (r"\\(?:geq?|ge)\b", "≥"),
    (r"\\(?:leq?|le)\b", "≤"),
    (r"\\approx", "≈"),
    (r"\\infty", "∞"),
    (r"\\times", "×"),
    (r"\\to\b", "→"),
    (r"\\\|", "‖"),
    (r"\\#", "#"),
    (r"\^\{?2\}?", "²"),
    (r"\^\{?3\}?", "³"),
    (r"_\{?m\}?(?![a-z])", "ₘ"),
    (r"\\[,;! ]|\\q?quad", " "),
    (r"[{}]|\\", ""),
)


def spoken(tex: str) -> str:
    """Return LaTeX in plain letters, as near as they come."""
    for pattern, to in _PLAIN:
        tex = re.sub(pattern, to, tex)
    return " ".join(tex.split())


def plain(text: str) -> str:
    """Return a line of Markdown without its marks, for a button or a list."""
    text = re.sub(r"\$([^$\n]+?)\$", lambda m: spoken(m[1]), text)
    return re.sub(r"\*\*(.+?)\*\*|\*(.+?)\*|`(.+?)`", lambda m: m[1] or m[2] or m[3], text)
