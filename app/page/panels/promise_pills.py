"""Whether the promise of the paper's law stands at this moment, and the levers, as pills."""

from typing import Final

from markupsafe import Markup

from app.i18n.speaking import decimal, tr
from app.text.law_texts import LAW_TEXTS
from app.text.templates import macros, tr_html
from controllers.laws.situation import FIRM_LEVER
from controllers.limits import Authority
from scenes.history import Sample
from scenes.laws import LEVER_LAW
from scenes.promise import Condition, missing_now
from scenes.simulation import Simulation

BOUND: Final = Markup("d ≥ d<sub>m</sub>")
"""What the paper's law promises."""

BELOW: Final = 1e-3
"""So far below d_m a distance counts as lost [m]; a time step alone makes less."""


def promise_html(simulation: Simulation, sample: Sample, custom: bool = False) -> Markup:
    """Return whether d ≥ d_m is promised at this moment, or which conditions are missing, and the lever s of every arm that
    keeps clear, as pills; nothing where there is nothing to meet.

    Args:
        custom: whether a student's law runs.
    """
    if sample.pair < 0:
        return Markup()
    law = simulation.settings.law
    if not custom and (promise := LAW_TEXTS[law.law].promise) is not None:
        pill = ("", promise(law))
    elif custom or not law.entry.promises:
        pill = ("", tr_html("this law does not promise {bound}", bound=BOUND))
    else:
        pill = promise_words(simulation, sample)
    levers = [sample.lever] if sample.second is None else [sample.lever, sample.second.lever]
    weak = min(levers) < FIRM_LEVER
    lever = ("halt" if weak else "", tr("lever s = {s}", s="; ".join(decimal(f"{s:.2f}") for s in levers)))
    # Beside a person's lever, s would be taken for it.
    return pills_html([pill] if law.law == LEVER_LAW and not custom else [lever, pill])


def promise_words(simulation: Simulation, sample: Sample) -> tuple[str, str]:
    """Return class and words of the promise of the paper's law at this moment."""
    lost = missing_now(simulation.settings, simulation.history)
    if lost:
        why = ", ".join(_condition_text(condition, simulation, sample) for condition in lost)
        return "alarm", tr_html("{bound} may fail: {why}", bound=BOUND, why=why)
    if sample.law_distance < simulation.settings.law.critical_distance - BELOW:
        return "halt", tr_html("below d<sub>m</sub>, but falling no further")
    return "go", tr_html("{bound} stands", bound=BOUND)


def _condition_text(condition: Condition, simulation: Simulation, sample: Sample) -> str:
    match condition:
        case Condition.SPEED:
            return "w > v"
        case Condition.LEVER:
            s = sample.lever if sample.second is None else min(sample.lever, sample.second.lever)
            return tr("no lever (s = {s})", s=decimal(f"{s:.2f}"))
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


def pills_html(pills: list[tuple[str, str]]) -> Markup:
    """Return pills, each of a class of CSS and words."""
    return macros("page/panels/pills.html").pills(pills)
