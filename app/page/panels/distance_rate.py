"""Sum ḋ, its consequence, and the paper's promise."""

import math
from typing import Final, NamedTuple

from markupsafe import Markup

from app.i18n.speaking import N_, decimal, tr
from app.plots.time_series import resting_now
from app.session.frame import Contact
from app.stage.contact_view import bodies_of_pair
from app.text.first_task_texts import in_symbols, wording
from app.text.law_texts import LAW_TEXTS
from app.text.lever_texts import NO_LEVER, lever_text
from app.text.templates import macros, tr_html
from controllers.budget import largest_dead_time, largest_dead_time_without_overshoot, settling_time
from controllers.laws.situation import FIRM_LEVER
from controllers.limits import Authority
from scenes.history import Sample
from scenes.law_answers import LawOfFile
from scenes.laws import LEVER_LAW
from scenes.promise import Condition, missing_now
from scenes.settings import HardwareSettings, RunSettings
from scenes.simulation import Simulation
from scenes.world_stages import Thing

MISSED: Final = 0.01
"""Reported difference from the law's ḋ [m/s]."""

OPENING: Final = 0.008
"""Least ḋ of an opening gap [m/s]."""

HOLDING: Final = 0.003
"""ḋ below which an opening gap holds again (hysteresis) [m/s]."""


class Term(NamedTuple):
    """A part of ḋ.

    Attributes:
        kind: CSS class of its colour; "lost" for what the robot does not achieve, 0 below `MISSED`.
        symbol: as HTML.
        value: contribution [m/s]; positive opens the gap.
    """

    kind: str
    symbol: str
    word: str
    value: float


def trend(rate: float, before: int) -> int:
    """1 if the gap opens at ḋ [m/s], −1 if it closes, 0 if it holds. `before`: the previous value."""
    if rate * before > HOLDING:
        return before
    if rate > OPENING:
        return 1
    return -1 if rate < -OPENING else 0


def wanted_rate(simulation: Simulation, sample: Sample, now: Contact) -> float:
    """ḋ that the law asks for; the actual ḋ of a custom law [m/s]."""
    law, second = simulation.law, sample.second
    if isinstance(law, LawOfFile):
        return now.change
    rate = law.line_rate(now.distance, now.pull, now.approach, now.square)
    if second is None:
        return rate - now.approach
    return rate + law.line_rate(now.distance, second.pull, second.law_approach, now.second_square)


def budget_terms(simulation: Simulation, sample: Sample, now: Contact) -> list[Term]:
    """Parts of ḋ: obstacle, task, loss, and law; their sum is the present ḋ within `MISSED`."""
    law, second, kept = simulation.settings.law, sample.second, simulation.settings.quantity
    wanted, pull = wanted_rate(simulation, sample, now), now.pull + (0.0 if second is None else second.pull)
    terms: list[Term] = []
    # What one of two arms does need not count as an approach of the other.
    if second is None and (now.approach != 0.0 or not simulation.settings.one_row):
        terms.append(Term("w", _in("w", "w"), tr(wording("approach", kept)), -now.approach))
    if isinstance(simulation.law, LawOfFile):
        return [
            *terms,
            Term(
                "v",
                in_symbols("J<sub>d</sub>q̇", kept),
                tr("your law"),
                wanted - sum(term.value for term in terms),
            ),
        ]
    u = _in("u", "u") if second is None else f"({_in('u', 'u')}<sub>1</sub>+{_in('u', 'u')}<sub>2</sub>)"
    budget = law.entry.budget
    share = {"share": LAW_TEXTS[law.law].share, "switch": "λ"}.get(budget, "")
    if budget != "avoidance":
        left = 1.0 - sample.activation if budget in ("share", "switch") else 1.0
        terms.append(Term("u", (f"(1−{_in('lam', share)})" if share else "") + u, tr("task"), -left * pull))
    lost, added = _lost(simulation, now, wanted), wanted - sum(term.value for term in terms)
    if budget == "task":
        return [*terms, lost]
    if budget == "push":
        return [*terms, Term("lam", in_symbols("|J<sub>d</sub>|²f", kept), tr("push"), added), lost]
    if budget == "correction":
        return [*terms, lost, Term("v", "c", tr("held back"), added)]
    v, w = _in("v", "v"), _in("w", "w")
    symbol = _in("lam", share) + (f"({v}+{w})" if law.knows_w else v)
    if second is None:
        return [*terms, lost, Term("v", symbol, tr("retreat"), added)]
    return [*terms, lost, Term("v", symbol if law.knows_w else f"2{symbol}", tr("both retreat"), added)]


def _lost(simulation: Simulation, now: Contact, wanted: float) -> Term:
    lost = now.change - wanted
    seen = simulation.history.count > 0 and abs(lost) >= MISSED
    return Term("lost", tr("a part of a sum\x04lost"), tr("not achieved"), lost if seen else 0.0)


def allowed_rate(run: RunSettings, sample: Sample) -> float:
    """Fastest approach γ (d − d_m) that a barrier allows [m/s]; nan under another law."""
    law = run.law
    return law.barrier_gain * (sample.distance - law.critical_distance) if law.entry.has_barrier else math.nan


def consequence(simulation: Simulation, sample: Sample, now: Contact) -> str:
    """Consequence as HTML; "" if the resting distance shows it."""
    return in_symbols(_consequence(simulation, sample, now), simulation.settings.quantity)


def _consequence(simulation: Simulation, sample: Sample, now: Contact) -> str:
    run = simulation.settings
    law, texts = run.law.entry, LAW_TEXTS[run.law.law]
    if law.rests:
        rest = resting_now(simulation, sample)
        return (_no_rest(run, sample) if rest != rest else "") + _late_text(run, now, sample)
    if texts.trends:
        return tr(wording(texts.trends[trend(now.true_change, 0) + 1], run.quantity))
    if law.has_barrier:
        said = N_("may come nearer at γ(d − d<sub>m</sub>) at most: {rate} m/s")
        if sample.distance < run.law.critical_distance:
            said = N_("has to open at γ(d<sub>m</sub> − d) at least: {rate} m/s")
        # The page fills in the number.
        return tr_html(wording(said, run.quantity), rate=Markup('<span data-allowed=""></span>'))
    said = texts.acting if texts.acting and sample.activation > 0.0 else texts.consequence
    return tr(wording(said, run.quantity))


def _no_rest(run: RunSettings, sample: Sample) -> str:
    if sample.second is None and sample.law_approach > run.law.nominal_velocity and not run.law.knows_w:
        return tr("no rest, w &gt; v")
    kept = run.quantity
    why = lever_text(least_lever(sample), kept) or tr(wording("between two pairs", kept))
    return tr("no rest: {why}", why=why)


def _late_text(run: RunSettings, now: Contact, sample: Sample) -> str:
    """a T and its effect; "" without a dead time or a rest."""
    law, T = run.law, run.hardware.dead_time
    if T == 0.0 or sample.second is not None:
        return ""
    v = law.nominal_velocity + (now.approach if run.adds_w else 0.0)
    settling = settling_time(law.critical_distance, law.order, v, now.pull, now.approach)
    if not 0.0 < settling < math.inf:
        return ""
    if largest_dead_time(settling, run.hardware.lag) <= T:
        words = tr("never settles")
    else:
        words = tr("overshoots") if largest_dead_time_without_overshoot(settling) < T else tr("calm")
    return f"a T = {decimal(f'{T / settling:.2f}')}: {words}"


def missed(simulation: Simulation, sample: Sample) -> str:
    """Reason why ḋ differs from the law's."""
    if simulation.bound_bites:
        return tr("a joint is at its bound")
    if reason := LAW_TEXTS[simulation.settings.law.law].missed:
        return tr(wording(reason, simulation.settings.quantity))
    if simulation.settings.hardware != HardwareSettings():
        return tr("the robot is not ideal")
    return lever_text(least_lever(sample), simulation.settings.quantity) or tr("a moment behind")


def error_step(run: RunSettings) -> str:
    """Effect of a step on a single arm's error, as HTML."""
    k = run.gain * run.overdrive * run.dt
    e = _in("e", "e")
    if k == 0.0:
        return tr("nothing brings e back: the hand drifts")
    if k < 1.0:
        return tr(
            "{e} shrinks by {share} % a step", e=e, share=decimal(f"{100.0 * k:.{0 if k >= 0.1 else 1}f}")
        )
    if k < 2.0:
        return tr("{e} changes its sign at every step, and shrinks", e=e)
    return tr("{e} grows until the joints are at their top speed", e=e)


def _in(symbol: str, text: str) -> str:
    return f'<b class="{symbol}">{text}</b>' if text else ""


def bound_of(run: RunSettings) -> Markup:
    """The paper's promise, as HTML."""
    symbol = run.quantity.symbol
    return Markup(f"{symbol} ≥ {symbol}<sub>m</sub>")


BELOW: Final = 1e-3
"""Depth below d_m at which the promise is broken [m]; a time step alone causes less."""

BOLTED: Final = N_("the nearest part is bolted down")

ACTS: Final = 0.01
"""Least λ that moves an arm visibly."""


def promise_html(simulation: Simulation, sample: Sample, custom: bool = False) -> Markup:
    """Pills with the promise d ≥ d_m or its missing conditions, and the lever s of every avoiding arm;
    empty without an obstacle."""
    if sample.pair < 0:
        return Markup()
    law, kept = simulation.settings.law, simulation.settings.quantity
    if not custom and (promise := LAW_TEXTS[law.law].promise) is not None:
        pill = ("", in_symbols(promise(law), kept))
    elif custom or not law.entry.promises:
        pill = ("", tr_html("this law does not promise {bound}", bound=bound_of(simulation.settings)))
    else:
        pill = promise_words(simulation, sample)
    levers = [sample.lever] if sample.second is None else [sample.lever, sample.second.lever]
    # At λ = 0 the law moves nothing, and a short lever costs nothing.
    weak = least_lever(sample) < FIRM_LEVER and sample.activation >= ACTS
    lever = (
        "halt" if weak else "",
        tr(
            wording("joints move this point: s = {s}", kept),
            s="; ".join(decimal(f"{s:.2f}") for s in levers),
        ),
    )
    # Next to a person's lever, s would be mistaken for it.
    return pills_html([pill] if law.law == LEVER_LAW and not custom else [lever, pill])


def promise_words(simulation: Simulation, sample: Sample) -> tuple[str, str]:
    lost, law = missing_now(simulation.settings, simulation.history), simulation.settings.law
    lowest = law.critical_distance - BELOW
    failed, kept = sample.distance < lowest, simulation.settings.quantity
    if lost:
        why = ", ".join(_condition_text(condition, simulation, sample) for condition in lost)
        said = N_("{bound} has failed: {why}") if failed else N_("{bound} may fail: {why}")
        return "alarm", tr_html(said, bound=bound_of(simulation.settings), why=why)
    if failed:
        return "halt", in_symbols(tr_html("below d<sub>m</sub>, but falling no further"), kept)
    if sample.law_distance < lowest:
        said = wording("the law distance is below d<sub>m</sub>, but falling no further", kept)
        return "halt", in_symbols(tr_html(said), kept)
    return "go", tr_html("{bound} is promised", bound=bound_of(simulation.settings))


def least_lever(sample: Sample) -> float:
    return sample.lever if sample.second is None else min(sample.lever, sample.second.lever)


def nearest_is_bolted(simulation: Simulation, sample: Sample) -> bool:
    """True if the law asks an arm to move a body without a joint, such as a pedestal."""
    if (
        sample.pair < 0
        or not simulation.room.meets_bodies
        or sample.authority != Authority.LEVERAGE
        or sample.lever >= NO_LEVER
    ):
        return False
    body, _ = bodies_of_pair(simulation, sample.pair)
    return simulation.room.geometry.geometryObjects[body].parentJoint == 0


PRESSED: Final[dict[Thing | None, str]] = {
    "table": N_("pressed against the table"),
    "floor": N_("pressed against the floor"),
    "stand": N_("pressed against the stand"),
    "pedestal": N_("pressed against the pedestal"),
    "itself": N_("pressed against itself"),
    None: N_("pressed against its surroundings"),
}


def _pressing(simulation: Simulation, sample: Sample) -> Thing | None:
    if simulation.stages is None:
        return None
    arm = simulation.avoiding if sample.authority == Authority.WORLD else simulation.guided
    # The stage acts on the distance a little before the arm counts as touching.
    touch = simulation.stages.touch_of(arm.joints, math.inf)
    return None if touch is None else touch.thing


def _condition_text(condition: Condition, simulation: Simulation, sample: Sample) -> str:
    kept = simulation.settings.quantity
    match condition:
        case Condition.SPEED:
            return "w > v"
        case Condition.LEVER:
            if nearest_is_bolted(simulation, sample):
                return tr(BOLTED)
            s = least_lever(sample)
            words = lever_text(s, kept) or tr(wording("the joints move this point too little", kept))
            return f"{words} (s = {decimal(f'{s:.2f}')})"
        case Condition.BOUND:
            second = sample.second
            if second is None or sample.authority in (Authority.STOP, Authority.SPEED):
                joint = simulation.joint_label(sample.joint)
            else:
                joint = simulation.joint_label(second.joint, second=True)
            return tr("{joint} at its limit", joint=tr(joint))
        case Condition.WORLD:
            return tr(wording(PRESSED[_pressing(simulation, sample)], kept))
        case Condition.ROBOT:
            return tr("the robot is not ideal")
        case Condition.PAIRS:
            return tr(wording("between two pairs", kept))


def pills_html(pills: list[tuple[str, str]]) -> Markup:
    return macros("page/panels/pills.html").pills(pills)
