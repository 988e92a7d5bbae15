"""Whether the promise of the paper's law stands at this moment, and the levers, as pills."""

from typing import Final

from app.i18n.speaking import tr
from controllers.laws.situation import FIRM_LEVER
from controllers.limits import Authority
from scenes.history import Sample
from scenes.promise import Condition, makes_promise, missing_now
from scenes.simulation import Simulation

BELOW: Final = 1e-3
"""So far below d_m a distance counts as lost [m]; a time step alone makes less."""


def promise_html(simulation: Simulation, sample: Sample, custom: bool = False) -> str:
    """Return whether d ≥ d_law ≥ d_m is promised at this moment, or which conditions are missing, and the lever s of every arm that
    keeps clear, as pills; nothing where there is nothing to meet.

    Args:
        custom: whether a student's law runs.
    """
    if sample.pair < 0:
        return ""
    bound = "d ≥ d<sub>law</sub> ≥ d<sub>m</sub>"
    if custom or not makes_promise(simulation.settings.law):
        pill = ("", tr("this law does not promise {bound}", bound=bound))
    else:
        pill = promise_words(simulation, sample, bound)
    levers = [sample.lever] if sample.second is None else [sample.lever, sample.second.lever]
    weak = min(levers) < FIRM_LEVER
    lever = ("halt" if weak else "", tr("lever s = {s}", s=", ".join(f"{s:.2f}" for s in levers)))
    return pills_html([lever, pill])


def promise_words(simulation: Simulation, sample: Sample, bound: str) -> tuple[str, str]:
    """Return class and words of the promise of the paper's law at this moment. `bound`: what is promised, as HTML."""
    lost = missing_now(simulation.settings, simulation.history)
    if lost:
        why = ", ".join(_condition_text(condition, simulation, sample) for condition in lost)
        return "alarm", tr("{bound} may fail: {why}", bound=bound, why=why)
    if sample.law_distance < simulation.settings.law.critical_distance - BELOW:
        return "halt", tr("below d<sub>m</sub>, but d falls no further: every condition is met")
    return "go", tr("{bound} stands", bound=bound)


def _condition_text(condition: Condition, simulation: Simulation, sample: Sample) -> str:
    match condition:
        case Condition.SPEED:
            return "w &gt; v"
        case Condition.LEVER:
            s = sample.lever if sample.second is None else min(sample.lever, sample.second.lever)
            return tr("no lever (s = {s})", s=f"{s:.2f}")
        case Condition.BOUND:
            second = sample.second
            if second is None or sample.authority in (Authority.STOP, Authority.SPEED):
                joint = simulation.joint_label(sample.joint)
            else:
                joint = simulation.joint_label(second.joint, second=True)
            return tr("{joint} at its limit", joint=tr(joint))
        case Condition.ROBOT:
            return tr("the robot is not ideal")
        case Condition.PAIRS:
            return tr("between two pairs")


def pills_html(pills: list[tuple[str, str]]) -> str:
    """Return pills as HTML, each of a class and words."""
    return "".join(f'<span class="{kind}">{text}</span>' for kind, text in pills)
