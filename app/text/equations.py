"""The equation of every law as SVG, its symbols in their colours, and where it comes from."""

import re
from typing import Final

from markupsafe import Markup

from app.i18n.speaking import tr
from app.text.formula import coloured, formula
from app.text.law_texts import LAW_TEXTS
from app.text.templates import macros
from scenes.settings import RunSettings

ALONE: Final = ((r"\dot q = J^{{\#}}\left(\dot x_d + K\,{e}\right) + N\,\dot q_0", r"N = I - J^{{\#}}J"), "(4)–(8)")
"""The equation of one arm with nothing near."""

_SYMBOLS: Final = {"lam": r"\lambda", "v": "v", "u": "u", "d": "d", "dm": "d_m", "e": "e"}
_COLOURED: Final = {name: coloured(name, symbol) for name, symbol in _SYMBOLS.items()}
_WORDS: Final = re.compile(r"\\text\{\{(.+?)\}\}")


def equation_of(run: RunSettings) -> tuple[tuple[str, ...], str]:
    """Return the equation of a run, as lines of LaTeX, and its source."""
    texts = LAW_TEXTS[run.law.law]
    return ALONE if run.experiment.obstacle == "nothing" else (texts.equation, texts.source)


def equation_html(run: RunSettings) -> Markup:
    """Return the equation of a run with its source, in the visitor's language."""
    equation, source = equation_of(run)
    lines = (_WORDS.sub(lambda found: rf"\text{{{{{tr(found[1])}}}}}", line).format(**_COLOURED) for line in equation)
    drawings = [Markup(formula(line, False, 17.0)) for line in lines]
    return macros("text/equation.html").equation(drawings, tr(source))
