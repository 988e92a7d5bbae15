"""LaTeX drawn as SVG with coloured symbols."""

import html
import logging
import re
from functools import lru_cache
from typing import Final

from ziamath import zmath
from ziamath.config import config

from app.theme import PALETTES, SYMBOL_COLOURS

log = logging.getLogger("duet.lessons")

SIZE: Final = 16.0
"""Letter size [CSS px]."""

SMALLEST: Final = 14.0
"""Letter size of a formula too wide for its panel, as of text [CSS px]."""

_COLOURS: Final = {name: getattr(PALETTES["light"], field) for name, field in SYMBOL_COLOURS.items()}

_SYMBOLS: Final = re.compile(
    r"(?P<words>\\(?:text|mathrm|operatorname|mathbb|mathbf|textcolor)\s*\{[^{}]*\})"
    r"|(?P<lam>\\lambda(?![A-Za-z]))|(?P<dm>d_m(?![A-Za-z])|d_\{m\})|(?<![\\A-Za-z_^])(?P<letter>[vuw])(?![A-Za-z])"
    # Not the index of J_d, nor d^* and d_i, nor the rate of d.
    r"|(?<![\\A-Za-z_^])(?<!_\{)(?<!dot )(?<!dot\{)(?P<d>d)(?![A-Za-z_]|\^\*)"
)
"""Symbols to colour; words and colour names match first and are left alone."""

_PAIRS: Final = (("{", "}"), (r"\begin{", r"\end{"), (r"\left", r"\right"))
"""Delimiters between which a formula must not break."""

_TAG: Final = re.compile(r"\\tag\s*\{([^{}]*)\}")


@lru_cache(maxsize=4096)
def formula(tex: str, inline: bool, size: float = SIZE) -> str:
    """LaTeX as SVG with a label for screen readers, or as code if it cannot be drawn. `size`: [CSS px]."""
    # Shared <symbol> ids of several formulas on one page would collide.
    config.svg2 = False
    for source in (_SYMBOLS.sub(_coloured, tex), tex):
        try:
            drawn = zmath.Latex(source, size=size, inline=inline)
            svg, below = drawn.svg(), drawn.getyofst()
            break
        except Exception:
            # A formula that the library cannot draw must not stop the page.
            continue
    else:
        log.warning("a formula cannot be drawn: %s", tex[:80])
        return f"<code>{html.escape(tex)}</code>"
    for name, colour in _COLOURS.items():
        svg = svg.replace(f'fill="{colour}"', f'class="{name}" fill="currentColor"')
    svg = svg.replace('fill="black"', 'fill="currentColor"')
    # A wide one may shrink to the size of the text around it; beyond that its line scrolls.
    width = float(svg.partition('width="')[2].partition('"')[0])
    place = (
        f' style="vertical-align:{below:.2f}px"'
        if inline
        else f' style="min-width:{SMALLEST / size * width:.0f}px"'
    )
    return svg.replace(
        "<svg ",
        f'<svg role="img" aria-label="{html.escape(plain_formula(tex))}" fill="currentColor"{place} ',
        1,
    )


def _coloured(found: re.Match[str]) -> str:
    return found[0] if found["words"] else coloured(found["letter"] or str(found.lastgroup), found[0])


def coloured(name: str, symbol: str) -> str:
    return rf"{{\textcolor{{{_COLOURS[name]}}}{{{symbol}}}}}"


_PLAIN: Final = (
    (r"\{\\textcolor\{#\w+\}\{([^{}]*)\}\}", r"\1"),
    (r"\\(?:left|right)(?![a-z])", ""),
    (r"\\eta", "η"),
    (r"\\(?:text|mathrm|operatorname|mathbb|mathbf)\s*\{([^{}]*)\}", r"\1"),
    (r"_\{(\w+)\}", r"_\1"),
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


def plain_formula(tex: str) -> str:
    for pattern, to in _PLAIN:
        tex = re.sub(pattern, to, tex)
    return " ".join(tex.split())


def display_formula(tex: str) -> str:
    r"""LaTeX as SVG for its own line, with the number of its `\tag{…}`; it may break at every `\qquad`."""
    number = ", ".join(_TAG.findall(tex))
    shown = f'<span class="no">({html.escape(number)})</span>' if number else ""
    whole = " ".join(_TAG.sub("", tex).split())
    parts = whole.split(r"\qquad")
    if len(parts) == 1 or any(
        part.count(one) != part.count(other) for part in parts for one, other in _PAIRS
    ):
        return formula(whole, False) + shown
    return f"<span>{' '.join(formula(part.strip(), False) for part in parts)}</span>{shown}"
