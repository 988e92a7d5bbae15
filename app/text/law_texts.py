"""Texts of laws, and their equations as HTML."""

import re
from collections.abc import Callable
from typing import Final, NamedTuple

import numpy as np
from markupsafe import Markup

from app.i18n.speaking import tr
from app.text.formula import coloured, formula
from app.text.templates import macros, tr_html
from controllers.curve import kept_distance
from scenes.laws import BARRIER_LAW, DEFAULT_LAW, DRAWN_LAW, LEVER_LAW, NO_AVOIDANCE
from scenes.quantities import DISTANCE
from scenes.settings import LawSettings, RunSettings


class LawLine(NamedTuple):
    """A law's line in the chart of all laws: distances xs (k,) [m], ascending, rates ys (k,) [m/s], largest
    rate of the axis.
    """

    xs: np.ndarray
    ys: np.ndarray
    span: float


class LawTexts(NamedTuple):
    """Texts of a law.

    Attributes:
        equation: LaTeX lines; {lam}, {v}, {u}, {d} and {dm} become coloured symbols. λ is any activation.
        source: number in the paper, or authors.
        share: name of the activation.
        anchor: distance [m] of the line's number in the chart of all laws, away from other lines.
        consequence: what happens to the gap, as HTML; "" if the resting distance says it.
        acting: the same while avoidance acts.
        trends: the same while the gap closes, holds and opens.
        promise: promised distance and its condition, as HTML; None for the paper's or none.
        missed: reason why ḋ differs from the law's demand, if that is the law itself.
    """

    equation: tuple[str, ...]
    source: str
    share: str
    anchor: Callable[[LawSettings, LawLine], float]
    consequence: str = ""
    acting: str = ""
    missed: str = ""
    trends: tuple[str, str, str] | tuple[()] = ()
    promise: Callable[[LawSettings], Markup] | None = None


def _promise_of_curve(law: LawSettings) -> Markup:
    kept = kept_distance(law.curve)
    if kept is None:
        return tr_html("this curve promises nothing: it does not begin at 1")
    return tr_html("this curve promises d ≥ {kept} mm while w ≤ v", kept=f"{1e3 * kept:.0f}")


LAW_TEXTS: Final[dict[str, LawTexts]] = {
    DEFAULT_LAW: LawTexts(
        (r"\dot q = J_d^{{\#}}\,{lam}\,{v} + \left(I - {lam}\,J_d^{{\#}} J_d\right)\dot q_n",), "(32), (33)", "λ",
        lambda law, line: law.critical_distance * 0.72 ** (-1.0 / law.order),
    ),
    "strict_priority": LawTexts(
        (r"\dot q = J_d^{{\#}}\,{v} + \left(I - J_d^{{\#}} J_d\right)\dot q_n",), "(11)", "priority",
        lambda law, line: 0.92 * line.xs[-1],
        trends=(
            "the task has no say, and the gap closes",
            "the task has no say, and the gap holds",
            "an endless retreat, whatever the task wants",
        ),
    ),
    "strict_switched": LawTexts(
        (r"\dot q = J_d^{{\#}}\,{v} + \left(I - J_d^{{\#}} J_d\right)\dot q_n \quad ({d} \leq {dm})",
         r"\dot q = \dot q_n \quad ({d} > {dm})"), "(11), switched", "priority λ",
        # On its jump, nearer to the lower end.
        lambda law, line: law.critical_distance + 0.65e-6,
        "above d<sub>m</sub> the task alone", acting="avoidance first",
    ),
    "null_space_avoidance": LawTexts(
        (r"\dot q = \dot q_n + N\left(J_d N\right)^{{\#}}{lam}\left({v} + {u}\right)", r"N = I - J^{{\#}}J"),
        "Žlajpah & Nemec 2002", "λ",
        lambda law, line: law.critical_distance + 0.6 * max(law.influence_distance - law.critical_distance, 0.0),
        "as far as the hand leaves the joints free", missed="the hand comes first",
    ),
    "potential_field": LawTexts(
        (r"\dot q = \dot q_n + J_d^{{T}}\,\frac{{\eta}}{{{d}^2}}\left(\frac{{1}}{{{d}}} - \frac{{1}}{{d_0}}\right)",),
        "Khatib 1986", "push, of 1",
        # High on its flank, where the others are not.
        lambda law, line: float(np.interp(-0.72 * line.span, -line.ys, line.xs, left=0.08)),
        "nothing is promised",
    ),
    BARRIER_LAW: LawTexts(
        (r"\min\ \left|\dot q - \dot q_n\right|^2 \quad \text{{so that}}",
         r"J_{{d,i}}\,\dot q \geq -\gamma\left({d}_i - {dm}\right)\quad \text{{for all }} i"),
        "Faverjon & Tournassoud 1987", "1 − allowed",
        lambda law, line: max(law.critical_distance - 0.25 * line.span / law.barrier_gain, 0.03),
        missed="other pairs count, too",
    ),
    "intermediate_value": LawTexts(
        (r"\dot q = J_d^{{\#}}\dot x_a + \left(J N_a\right)^{{\#}}\left(\dot x_b - J J_d^{{\#}}\dot x_a\right)",
         r"\dot x_a = {lam}\,{v} - \left(1 - {lam}\right){u}"), "Lee, Mansard & Park 2012", "λ",
        lambda law, line: law.critical_distance * 0.24 ** (-1.0 / law.order),
    ),
    "task_activation": LawTexts(
        (r"\dot q = \dot q_n + \delta - Q_1\left(J Q_1\right)^{{\#}} W_2\,J\,\delta",
         r"\delta = a^2 J_d^{{\#}}\left({v} + {u}\right),\quad Q_1 = I - a\,J_d^{{\#}} J_d"), "Simetti & Casalino 2016", "a²",
        lambda law, line: law.critical_distance + 0.3 * max(law.influence_distance - law.critical_distance, 0.0),
        "as it activates, the hand takes its share", missed="the hand takes its share",
    ),
    "continuous_inverse": LawTexts(
        (r"\dot q = \left(1 - {lam}\right)\dot q_n + {lam}\left[J_d;\,J\right]^{{\#}}\left[{v};\,\dot x_b\right]",
         r"\dot x_b = J\,\dot q_n"), "Mansard, Remazeilles & Chaumette 2009", "λ",
        lambda law, line: law.critical_distance * 0.45 ** (-1.0 / law.order),
        "both tasks in one stack, neither first", missed="the hand takes its share",
    ),
    "hierarchical_inverse": LawTexts(
        (r"\dot q = \left(1 - {lam}\right)\dot q_n + {lam}\,\dot q_{{ab}} \quad \left({v} > -{u}\right)",
         r"\dot q_{{ab}} = J_d^{{\#}}{v} + \left(J N\right)^{{\#}}\left(\dot x_b - J J_d^{{\#}}{v}\right)"),
        "Mansard, Khatib & Kheddar 2009", "λ",
        lambda law, line: law.critical_distance * 0.6 ** (-1.0 / law.order),
        missed="a task that retreats faster is left alone",
    ),
    "lexicographic_qp": LawTexts(
        (r"\text{{first}}\quad J_{{d,i}}\,\dot q \geq -\gamma\left({d}_i - {dm}\right)\quad \text{{for all }} i",
         r"\text{{then}}\quad \min\ \left|J\left(\dot q - \dot q_n\right)\right|^2"), "Kanoun, Lamiraux & Wieber 2011", "1 − allowed",
        lambda law, line: max(law.critical_distance - 0.45 * line.span / law.barrier_gain, 0.03),
        missed="other pairs count, too",
    ),
    "set_based_task": LawTexts(
        (r"\dot q = \left(I - J_d^{{\#}} J_d\right)\dot q_n + J_d^{{\#}} k_r\left({dm} - {d}\right)",
         r"\quad\left({d} \leq {dm},\ -{u} < k_r\left({dm} - {d}\right)\right)",
         r"\dot q = \dot q_n \quad \text{{else, with a jump}}"), "Moe et al. 2016", "active",
        lambda law, line: max(law.critical_distance - 0.6 * line.span / max(law.restoring_gain, 1.0), 0.02),
        "inside the set the task alone; it jumps at d<sub>m</sub>", acting="frozen or returning",
    ),
    DRAWN_LAW: LawTexts(
        (r"\dot q = J_d^{{\#}}\,{lam}\,{v} + \left(I - {lam}\,J_d^{{\#}} J_d\right)\dot q_n", r"{lam} = {lam}({d})"),
        "(32), your λ", "λ",
        lambda law, line: float(line.xs[len(line.xs) // 2]),
        promise=_promise_of_curve,
    ),
    LEVER_LAW: LawTexts(
        (r"\dot q = J_d^{{\#}}\,{lam}\,{v} + \left(I - {lam}\,J_d^{{\#}} J_d\right)\dot q_n",
         r"{lam} \in [0, 1]"), "(32), your hand", "λ",
        lambda law, line: float(line.xs[len(line.xs) // 3]),
        promise=lambda law: tr_html("your lever promises nothing: it does not depend on d"),
    ),
    NO_AVOIDANCE: LawTexts(
        (r"\dot q = \dot q_n",), "the task alone", "λ",
        lambda law, line: 0.35 * law.critical_distance,
        "nothing keeps them apart",
    ),
}  # fmt: skip

ALONE: Final = (
    (r"\dot q = J^{{\#}}\left(\dot x_d + K\,{e}\right) + N\,\dot q_0", r"N = I - J^{{\#}}J"),
    "(4)–(8)",
)

_SYMBOLS: Final = {"lam": r"\lambda", "v": "v", "u": "u", "d": "d", "dm": "d_m", "e": "e"}
_COLOURED: Final = {name: coloured(name, symbol) for name, symbol in _SYMBOLS.items()}
_TEX: Final = {"σ": r"\sigma"}
_WORDS: Final = re.compile(r"\\text\{\{(.+?)\}\}")


def equation_of(run: RunSettings) -> tuple[tuple[str, ...], str]:
    texts = LAW_TEXTS[run.law.law]
    return ALONE if run.experiment.obstacle == "nothing" else (texts.equation, texts.source)


def equation_html(run: RunSettings) -> Markup:
    equation, source = equation_of(run)
    # A law of all pairs takes each pair's own d.
    named = run.has_law_distance and run.law.entry.sees == "one row"
    symbol = _TEX.get(run.quantity.symbol, run.quantity.symbol)
    d, of_law = coloured("d", symbol), coloured("d", "law")
    symbols = {**_COLOURED, "d": f"{d}_{{{of_law}}}" if named else d, "dm": coloured("dm", f"{symbol}_m")}
    if run.quantity is not DISTANCE:
        # x_a is another quantity, and its row is J_a.
        equation = tuple(line.replace("J_d", "J_a").replace("J_{{d,i}}", "J_{{a,i}}") for line in equation)
    lines = (
        _WORDS.sub(lambda found: rf"\text{{{{{tr(found[1])}}}}}", line).format(**symbols) for line in equation
    )
    drawings = [Markup(formula(line, False, 17.0)) for line in lines]
    if named:
        # The page writes this moment's law distance at it.
        drawings = [Markup(str(drawing).replace('class="d"', 'class="d law"')) for drawing in drawings]
    return macros("text/equation.html").equation(drawings, tr(source))
