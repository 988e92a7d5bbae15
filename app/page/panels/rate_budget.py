"""What opens and closes the gap along the line of contact: ḋ of the present law as a sum, and what follows from it."""

import math
from typing import Final, NamedTuple

from app.custom_law.custom_law import CustomLaw
from app.i18n.speaking import tr
from app.plots.time_series import resting
from app.session.contact import Contact
from controllers.budget import largest_dead_time, largest_dead_time_without_overshoot, settling_time
from controllers.laws.situation import AUTHORITY
from scenes.history import Sample
from scenes.settings import HardwareSettings, LawName, RunSettings
from scenes.simulation import Simulation

MISSED: Final = 0.01
"""A distance rate that differs from the law's by more than this is worth a word [m/s]."""

OPENING: Final = 0.008
"""From this ḋ on a gap opens [m/s], …"""

HOLDING: Final = 0.003
"""… and holds again below this one, so that the word does not flicker [m/s]."""

BLENDS: Final[tuple[LawName, ...]] = (
    *("smooth_priority", "strict_priority", "strict_switched", "null_space_avoidance"),
    *("intermediate_value", "task_activation", "continuous_inverse", "unprotected"),
)
"""Laws that make ḋ = λ v − (1 − λ) u − w, some of them with a λ of 0 or 1 alone; the others add something to the task."""


class Term(NamedTuple):
    """A part of ḋ.

    Attributes:
        kind: symbol that gives its colour, a class of the style sheet; "lost" for what the robot does not achieve, 0 below `MISSED`.
        symbol: its formula, as HTML.
        word: what it is.
        value: what it adds to ḋ [m/s]; positive opens the gap.
    """

    kind: str
    symbol: str
    word: str
    value: float


def trend(rate: float, before: int) -> int:
    """Return 1 if the gap opens at ḋ [m/s], −1 if it closes, 0 if it holds; `before`: what it did a moment ago."""
    if rate * before > HOLDING:
        return before
    return (rate > OPENING) - (rate < -OPENING)


def wanted_rate(simulation: Simulation, sample: Sample, now: Contact) -> float:
    """Return ḋ [m/s] as the law wants it; of a student's law, what it is."""
    law, second = simulation.law, sample.second
    if isinstance(law, CustomLaw):
        return now.change
    rate = law.line_rate(now.distance, now.pull, now.approach, now.square)
    if second is None:
        return rate - now.approach
    return rate + law.line_rate(now.distance, second.pull, second.law_approach, now.second_square)


def budget_terms(simulation: Simulation, sample: Sample, now: Contact) -> list[Term]:
    """Return the parts of ḋ: what the obstacle does, the task, what is lost, and the law; their sum is the ḋ of this moment, but for
    less than `MISSED`."""
    law, second = simulation.settings.law, sample.second
    wanted, pull = wanted_rate(simulation, sample, now), now.pull + (0.0 if second is None else second.pull)
    terms: list[Term] = []
    # What one of two arms does the other need not count as an approach.
    if second is None and (now.approach != 0.0 or not law.coupled):
        terms.append(Term("w", _in("w", "w"), tr("approach"), -now.approach))
    if isinstance(simulation.law, CustomLaw):
        return [*terms, Term("v", "J<sub>d</sub>q̇", tr("your law"), wanted - sum(term.value for term in terms))]
    u = _in("u", "u") if second is None else f"({_in('u', 'u')}<sub>1</sub>+{_in('u', 'u')}<sub>2</sub>)"
    if law.law not in BLENDS:
        terms.append(Term("u", u, tr("task"), -pull))
        added = wanted - sum(term.value for term in terms)
        if law.law == "potential_field":
            return [*terms, Term("lam", "|J<sub>d</sub>|²f", tr("push"), added), *_lost(simulation, now, wanted)]
        return [*terms, *_lost(simulation, now, wanted), Term("v", "c", tr("held back"), added)]
    lam, share = _share(law.law, sample.activation)
    if law.law != "strict_priority":
        terms.append(Term("u", (f"(1−{_in('lam', share)})" if share else "") + u, tr("task"), -(1.0 - lam) * pull))
    terms += _lost(simulation, now, wanted)
    if law.law == "unprotected":
        return terms
    knows_w = law.feed_forward and law.law == "smooth_priority"
    v, w = _in("v", "v"), _in("w", "w")
    symbol = _in("lam", share) + (f"({v}+{w})" if knows_w else v)
    retreat = lam * (law.nominal_velocity + (now.approach if knows_w else 0.0))
    if second is None:
        return [*terms, Term("v", symbol, tr("retreat"), retreat)]
    retreat += lam * (law.nominal_velocity + (second.law_approach if knows_w else 0.0))
    return [*terms, Term("v", symbol if knows_w else f"2{symbol}", tr("both retreat"), retreat)]


def _share(law: LawName, activation: float) -> tuple[float, str]:
    """Return λ of a law that blends and how it is written; "" if it is 0 or 1 alone."""
    match law:
        case "strict_priority":
            return 1.0, ""
        case "strict_switched":
            return float(activation > 0.0), ""
        case "unprotected":
            return 0.0, ""
        case "task_activation":
            return activation, "a²"
        case _:
            return activation, "λ"


def _lost(simulation: Simulation, now: Contact, wanted: float) -> list[Term]:
    lost = now.change - wanted
    seen = simulation.history.count > 0 and abs(lost) >= MISSED
    return [Term("lost", "", tr("not achieved"), lost if seen else 0.0)]


def allowed_rate(run: RunSettings, distance: float) -> float:
    """Return the fastest approach γ (d − d_m) that a barrier allows at a distance [m/s], nan under another law."""
    law = run.law
    return law.barrier_gain * (distance - law.critical_distance) if law.law == "barrier_qp" else math.nan


def consequence(run: RunSettings, sample: Sample, now: Contact) -> str:
    """Return what becomes of it, in a few words, as HTML; "" if the resting distance says it."""
    match run.law.law:
        case "smooth_priority" | "intermediate_value":
            rest = resting(run, now.pull, now.approach, None if sample.second is None else sample.second.pull)
            return (tr("no rest, w &gt; v") if rest != rest else "") + _late_text(run, now, sample)
        case "null_space_avoidance":
            return tr("as far as the hand leaves the joints free")
        case "strict_priority":
            return tr("a retreat for ever, whatever the task wants")
        case "strict_switched":
            return tr("avoidance first") if sample.activation > 0.0 else tr("above d<sub>m</sub> the task alone")
        case "potential_field":
            return tr("no distance is promised")
        case "barrier_qp":
            # The page fills the number in.
            return tr("may come nearer at γ(d − d<sub>m</sub>) at most") + '<span data-allowed=""></span>'
        case "task_activation":
            return tr("as it activates, the hand takes its share")
        case "continuous_inverse":
            return tr("hand and distance in one stack, neither first")
        case "set_based_task":
            return (
                tr("frozen or returning")
                if sample.activation > 0.0
                else tr("inside the set the task alone; it jumps at d<sub>m</sub>")
            )
        case _:
            return tr("nothing keeps them apart")


def _late_text(run: RunSettings, now: Contact, sample: Sample) -> str:
    """Return a T and what it means for the rest of an arm with a dead time; "" without a dead time or where there is no rest."""
    law, T = run.law, run.hardware.dead_time
    if T == 0.0 or sample.second is not None:
        return ""
    v = law.nominal_velocity + (now.approach if law.feed_forward else 0.0)
    settling = settling_time(law.critical_distance, law.order, v, now.pull, now.approach)
    if not 0.0 < settling < math.inf:
        return ""
    if largest_dead_time(settling, run.hardware.lag) <= T:
        words = tr("never settles")
    else:
        words = tr("overshoots") if largest_dead_time_without_overshoot(settling) < T else tr("calm")
    return f"a T = {T / settling:.2f}: {words}"


def missed(simulation: Simulation, now: Contact) -> str:
    """Return why ḋ is another one than the law wants."""
    law = simulation.settings.law.law
    if simulation.bound_bites:
        return tr("a joint is at its bound")
    if law == "barrier_qp":
        return tr("other pairs count, too")
    if law == "null_space_avoidance":
        return tr("the hand comes first")
    if law in ("task_activation", "continuous_inverse"):
        return tr("the hand takes its share")
    if simulation.settings.hardware != HardwareSettings():
        return tr("the robot is not ideal")
    if now.square < AUTHORITY**2:
        return tr("hardly a joint moves this point")
    return tr("a moment behind")


def error_step(run: RunSettings) -> str:
    """Return what a step makes of the error of an arm that stands alone, as HTML."""
    k = run.gain * run.overdrive * run.dt
    e = _in("e", "e")
    if k == 0.0:
        return tr("nothing brings e back: the hand drifts")
    if k < 1.0:
        return tr("{e} shrinks by {share} % a step", e=e, share=f"{100.0 * k:.{0 if k >= 0.1 else 1}f}")
    if k < 2.0:
        return tr("{e} changes its sign at every step, and shrinks", e=e)
    return tr("K dt ≥ 2: {e} grows at every step", e=e)


def _in(symbol: str, text: str) -> str:
    """Return text in the colour of a symbol; "" stays empty."""
    return f'<b class="{symbol}">{text}</b>' if text else ""
