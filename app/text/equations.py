"""The equation of every law as SVG, its symbols in their colours, and where it comes from."""

import re
from typing import Final, NamedTuple

from app.i18n.speaking import tr
from app.text.formula import coloured, formula
from scenes.settings import LawName, RunSettings


class Equation(NamedTuple):
    """The equation of a law.

    Attributes:
        lines: of LaTeX; {lam}, {v}, {u} and {dm} become coloured symbols.
        source: number in the paper, or its authors.
    """

    lines: tuple[str, ...]
    source: str


ALONE: Final = Equation((r"\dot q = J^{{\#}}\left(\dot x_d + K\,{e}\right) + N\,\dot q_0", r"N = I - J^{{\#}}J"), "(4)–(8)")
"""The equation of one arm with nothing near."""

EQUATIONS: Final[dict[LawName, Equation]] = {
    "smooth_priority": Equation(
        (r"\dot q = J_d^{{\#}}\,{lam}\,{v} + \left(I - {lam}\,J_d^{{\#}} J_d\right)\dot q_n",), "(32), (33)"
    ),
    "strict_priority": Equation((r"\dot q = J_d^{{\#}}\,{v} + \left(I - J_d^{{\#}} J_d\right)\dot q_n",), "(11)"),
    "strict_switched": Equation(
        (
            r"\dot q = J_d^{{\#}}\,{v} + \left(I - J_d^{{\#}} J_d\right)\dot q_n \quad ({d} \leq {dm})",
            r"\dot q = \dot q_n \quad ({d} > {dm})",
        ),
        "(11), switched",
    ),
    "null_space_avoidance": Equation(
        (r"\dot q = \dot q_n + N\left(J_d N\right)^{{\#}}{lam}\left({v} + {u}\right)", r"N = I - J^{{\#}}J"),
        "Žlajpah & Nemec 2002",
    ),
    "potential_field": Equation(
        (r"\dot q = \dot q_n + J_d^{{T}}\,\frac{{\eta}}{{{d}^2}}\left(\frac{{1}}{{{d}}} - \frac{{1}}{{d_0}}\right)",),
        "Khatib 1986",
    ),
    "barrier_qp": Equation(
        (
            r"\min\ \left|\dot q - \dot q_n\right|^2 \quad \text{{so that}}",
            r"J_{{d,i}}\,\dot q \geq -\gamma\left({d}_i - {dm}\right)\quad \text{{for all }} i",
        ),
        "Faverjon & Tournassoud 1987",
    ),
    "intermediate_value": Equation(
        (
            r"\dot q = J_d^{{\#}}\dot x_a + \left(J N_a\right)^{{\#}}\left(\dot x_b - J J_d^{{\#}}\dot x_a\right)",
            r"\dot x_a = {lam}\,{v} - \left(1 - {lam}\right){u}",
        ),
        "Lee, Mansard & Park 2012",
    ),
    "task_activation": Equation(
        (
            r"\dot q = \dot q_n + \delta - Q_1\left(J Q_1\right)^{{\#}} W_2\,J\,\delta",
            r"\delta = a^2 J_d^{{\#}}\left({v} + {u}\right),\quad Q_1 = I - a\,J_d^{{\#}} J_d",
        ),
        "Simetti & Casalino 2016",
    ),
    "continuous_inverse": Equation(
        (
            r"\dot q = \left(1 - {lam}\right)\dot q_n + {lam}\left[J_d;\,J\right]^{{\#}}\left[{v};\,\dot x_b\right]",
            r"\dot x_b = J\,\dot q_n",
        ),
        "Mansard, Remazeilles & Chaumette 2009",
    ),
    "set_based_task": Equation(
        (
            r"\dot q = \left(I - J_d^{{\#}} J_d\right)\dot q_n + J_d^{{\#}} k_r\left({dm} - {d}\right)",
            r"\quad\left({d} \leq {dm},\ -{u} < k_r\left({dm} - {d}\right)\right)",
            r"\dot q = \dot q_n \quad \text{{else, with a jump}}",
        ),
        "Moe et al. 2016",
    ),
    "unprotected": Equation((r"\dot q = \dot q_n",), "the task alone"),
}
"""What each law does; where the code fades in differently, λ stands for it."""

_SYMBOLS: Final = {"lam": r"\lambda", "v": "v", "u": "u", "d": "d", "dm": "d_m", "e": "e"}
_COLOURED: Final = {name: coloured(name, symbol) for name, symbol in _SYMBOLS.items()}
_WORDS: Final = re.compile(r"\\text\{\{(.+?)\}\}")


def equation_of(run: RunSettings) -> Equation:
    """Return the equation of a run."""
    return ALONE if run.scene == "solo" else EQUATIONS[run.law.law]


def equation_html(run: RunSettings) -> str:
    """Return the equation of a run with its source, in the visitor's language."""
    equation = equation_of(run)
    lines = (_WORDS.sub(lambda found: rf"\text{{{{{tr(found[1])}}}}}", line).format(**_COLOURED) for line in equation.lines)
    drawings = "".join(formula(line, False, 17.0) for line in lines)
    return f'<div class="duet-eq">{drawings}<span class="no">{tr(equation.source)}</span></div>'
