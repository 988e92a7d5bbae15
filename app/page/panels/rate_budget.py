"""The one line that tells everything along the line of contact: ḋ of the present law, with the numbers of this moment."""

import math
from typing import Final

from app.i18n.speaking import tr
from app.plots.time_series import resting
from app.session.contact import Contact
from controllers.budget import largest_dead_time, largest_dead_time_without_overshoot, settling_time
from controllers.laws.potential_field import PotentialField
from controllers.laws.situation import AUTHORITY
from scenes.history import Sample
from scenes.settings import HardwareSettings, LawName, RunSettings
from scenes.simulation import Simulation

MISSED: Final = 0.01
"""A distance rate that differs from the law's by more than this is worth a word [m/s]."""

_BLEND: Final = "{lam}{x}{v} − {rest}{x}{u}"
_FIRST: Final = "{v}"
_TASK: Final = "−{u}"

TEMPLATES: Final[dict[LawName, str]] = {
    "smooth_priority": _BLEND,
    "strict_priority": _FIRST,
    "strict_switched": _TASK,
    "null_space_avoidance": _BLEND,
    "potential_field": "{f} − {u}",
    "barrier_qp": "max(−{u}, −{gap})",
    "intermediate_value": _BLEND,
    "task_activation": _BLEND,
    "continuous_inverse": _BLEND,
    "set_based_task": _TASK,
    "unprotected": _TASK,
}
"""J_d q̇ of each law; `strict_switched` and `set_based_task` above d_m."""


def live_html(simulation: Simulation, sample: Sample, now: Contact) -> str:
    """Return the distance budget of the present law, as a formula and with numbers, and what follows from it."""
    if sample.pair < 0:
        lines = alone_lines(simulation)
    else:
        rate = wanted_rate(simulation, sample, now)
        formula, numbers = budget_lines(simulation, sample, now)
        lines = [
            f"{_in('d', 'ḋ')} = {formula}",
            f"= {numbers} = {_in('d', _fixed(rate, sign=True, digits=3))} m/s",
            # In one place, so that the controls below do not jump.
            missed(simulation, now, rate) or consequence(simulation, sample, now),
        ]
        if simulation.settings.law.law == "smooth_priority" and sample.second is None:
            lines[0] = f"{_law_now(simulation, sample, now)}<hr>{lines[0]}"
    return f'<div class="duet-live">{"<br>".join(lines)}</div>'


def wanted_rate(simulation: Simulation, sample: Sample, now: Contact) -> float:
    """Return ḋ [m/s] as the law wants it."""
    law, second = simulation.law, sample.second
    rate = law.line_rate(now.distance, now.pull, now.approach, now.square)
    if second is None:
        return rate - now.approach
    return rate + law.line_rate(now.distance, second.pull, second.law_approach, now.second_square)


def budget_lines(simulation: Simulation, sample: Sample, now: Contact) -> tuple[str, str]:
    """Return ḋ as a formula, and the same with this moment's numbers, as HTML."""
    law, second = simulation.settings.law, sample.second
    template = TEMPLATES[law.law]
    if law.law == "strict_switched" and sample.activation > 0.0:
        template = _FIRST
    if law.law == "set_based_task" and sample.activation > 0.0:
        template = "max(−{u}, {back})"
    if second is not None:
        # Either arm retreats by a row of its own: two of each, and what one does the other need not count as an approach.
        blends = "{lam}" in template
        template = "2" + template.replace("{lam}", "{x}{lam}", 1) if blends else template.replace("{v}", "2{x}{v}")
        if template.startswith("max"):
            template = "{one} + {other}"
    elif now.approach != 0.0 or not law.coupled:
        template += " − {w}"
    faster = law.feed_forward and law.law == "smooth_priority"
    v, w, u = _in("v", "v"), _in("w", "w"), _in("u", "u")
    lam, speed = sample.activation, law.nominal_velocity + (now.approach if faster else 0.0)
    line_rate = simulation.law.line_rate
    one = line_rate(now.distance, now.pull, now.approach, now.square)
    other = line_rate(now.distance, second.pull, second.law_approach, now.second_square) if second is not None else 0.0
    share = _in("lam", "a²" if law.law == "task_activation" else "λ")
    parts = {
        "x": ("", "·"),
        "lam": (share, _in("lam", f"{lam:.2f}")),
        "rest": (f"(1−{share})", _in("lam", f"{1.0 - lam:.2f}")),
        "v": (f"({v}+{w})" if faster else v, _in("v", _term(speed))),
        "u": (
            u if second is None else f"({u}<sub>1</sub>+{u}<sub>2</sub>)",
            _in("u", _term(now.pull if second is None else now.pull + second.pull)),
        ),
        "w": (w, _in("w", _term(now.approach))),
        "f": (("" if second is None else "Σ") + "|J<sub>d</sub>|²f", f"{_push(simulation, now):.2f}"),
        "gap": (
            f"γ({_in('d', 'd')}−{_in('dm', 'd<sub>m</sub>')})",
            _term(law.barrier_gain * (now.distance - law.critical_distance)),
        ),
        "back": (
            f"k<sub>r</sub>({_in('dm', 'd<sub>m</sub>')}−{_in('d', 'd')})" + (f"+{w}" if law.feed_forward else ""),
            _term(law.restoring_gain * (law.critical_distance - now.distance) + (now.approach if law.feed_forward else 0.0)),
        ),
        "one": (f"max(−{u}<sub>1</sub>, …)", _term(one)),
        "other": (f"max(−{u}<sub>2</sub>, …)", _term(other)),
    }
    symbols, numbers = ({name: pair[i] for name, pair in parts.items()} for i in (0, 1))
    return template.format(**symbols), template.format(**numbers)


def consequence(simulation: Simulation, sample: Sample, now: Contact) -> str:
    """Return what becomes of it, in a few words, as HTML."""
    run, law = simulation.settings, simulation.settings.law
    match law.law:
        case "smooth_priority" | "intermediate_value":
            rest = resting(run, now.pull, now.approach, None if sample.second is None else sample.second.pull)
            text = tr("no rest, w &gt; v") if rest != rest else tr("far away") if rest > 1.0 else f"{rest * 1000.0:.0f} mm"
            rests = tr("rests at {d} = {text}", d=_in("rest", "d*"), text=_in("rest", text))
            return f"{rests}{_late_text(run, now, sample)}"
        case "null_space_avoidance":
            return tr("as far as the hand leaves the joints free")
        case "strict_priority":
            return tr("a retreat for ever, whatever the task wants")
        case "strict_switched":
            return tr("avoidance first") if sample.activation > 0.0 else tr("above d<sub>m</sub> the task alone")
        case "potential_field":
            return tr("no distance is promised")
        case "barrier_qp":
            allowed = max(law.barrier_gain * (now.distance - law.critical_distance), 0.0)
            return tr("may come nearer at {speed} m/s", speed=f"{allowed:.2f}")
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
    v = law.nominal_velocity + (now.approach if law.feed_forward else 0.0)
    settling = settling_time(law.critical_distance, law.order, v, now.pull, now.approach)
    if T == 0.0 or sample.second is not None or not 0.0 < settling < math.inf:
        return ""
    if largest_dead_time(settling, run.hardware.lag) <= T:
        words = tr("never settles")
    else:
        words = tr("overshoots") if largest_dead_time_without_overshoot(settling) < T else tr("calm")
    return f", a T = {T / settling:.2f}: {words}"


def missed(simulation: Simulation, now: Contact, rate: float) -> str:
    """Return why ḋ really is another one; "" if it is not."""
    if abs(now.change - rate) < MISSED:
        return ""
    law = simulation.settings.law.law
    if simulation.bound_bites:
        why = tr("a joint is at its bound")
    elif law == "barrier_qp":
        why = tr("other pairs count, too")
    elif law == "null_space_avoidance":
        why = tr("the hand comes first")
    elif law in ("task_activation", "continuous_inverse"):
        why = tr("the hand takes its share")
    elif simulation.settings.hardware != HardwareSettings():
        why = tr("the robot is not ideal")
    elif now.square < AUTHORITY**2:
        why = tr("hardly a joint moves this point")
    else:
        why = tr("a moment behind")
    return tr("really {d}: {why}", d=_in("d", _fixed(now.change, sign=True, digits=3)), why=why)


def alone_lines(simulation: Simulation) -> list[str]:
    """Return what becomes of the error of an arm that stands alone, step by step."""
    run = simulation.settings
    gain = run.gain * run.overdrive
    k = gain * run.dt
    e = _in("e", "e")
    if k == 0.0:
        words = tr("nothing brings e back: the hand drifts")
    elif k < 1.0:
        words = tr("{e} shrinks by {share} % a step", e=e, share=f"{100.0 * k:.{0 if k >= 0.1 else 1}f}")
    elif k < 2.0:
        words = tr("{e} changes its sign at every step, and shrinks", e=e)
    else:
        words = tr("K dt ≥ 2: {e} grows at every step", e=e)
    return [f"{e} ← (1 − K dt) {e}", f"K dt = {gain:.3g}·{run.dt:.3g} = {k:.3g}", words]


def _law_now(simulation: Simulation, sample: Sample, now: Contact) -> str:
    law = simulation.settings.law
    lam, sharp = _in("lam", f"{sample.activation:.2f}"), "J<sub>d</sub><sup>#</sup>"
    v = law.nominal_velocity + (now.approach if law.feed_forward else 0.0)
    return f"q̇ = {sharp}·{lam}·{_in('v', _term(v))} + (I − {lam}·{sharp}J<sub>d</sub>) q̇<sub>n</sub>"


def _push(simulation: Simulation, now: Contact) -> float:
    """Return |J_d|² f(d), of both arms together if both keep clear [m/s]."""
    law = simulation.law
    return (now.square + now.second_square) * law.push(now.distance) if isinstance(law, PotentialField) else 0.0


def _in(symbol: str, text: str) -> str:
    """Return text in the colour of a symbol."""
    return f'<b class="{symbol}">{text}</b>'


def _term(value: float) -> str:
    """Return a number that may stand after a sign: a negative one in brackets."""
    text = _fixed(value)
    return f"({text})" if text.startswith("−") else text


def _fixed(value: float, sign: bool = False, digits: int = 2) -> str:
    """Return a number without the minus of a rounded zero, and with a true minus sign."""
    text = f"{value:+.{digits}f}" if sign else f"{value:.{digits}f}"
    if not text.strip("+-0."):
        text = text.lstrip("+-")
    return text.replace("-", "−")
