"""Values of other first tasks; units: `scenes.quantities`."""

from app.features.measures.evidence import Evidence
from app.features.measures.quantities.quantity import Reading, Value, at, quantity
from app.i18n.speaking import N_


@quantity("h", "mm", 0, live=True, obstacle=True)
def value_now(evidence: Evidence) -> Value:
    return float(evidence.column("d")[-1])


@quantity(N_("smallest h"), "mm", 1, obstacle=True)
def smallest_value(evidence: Evidence) -> Reading:
    h = evidence.column("d")
    return at(h, int(h.argmin()))


@quantity(N_("smallest h − hₘ"), "", 3, obstacle=True)
def value_margin(evidence: Evidence) -> Reading:
    """Without a unit, as simultaneous first tasks have several."""
    h = evidence.column("d")
    return at(h - evidence.settings.law.critical_distance, int(h.argmin()))
