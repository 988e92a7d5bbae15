"""Value of another first task than the distance of two arms; see `scenes.quantities` for its unit."""

from app.features.measures.evidence import Evidence
from app.features.measures.quantities.quantity import Reading, Value, at, quantity
from app.i18n.speaking import N_


@quantity("h", "mm", 0, live=True, obstacle=True)
def value_now(evidence: Evidence) -> Value:
    """Value that is a length [m]."""
    return float(evidence.column("d")[-1])


@quantity(N_("smallest h"), "mm", 1, obstacle=True)
def smallest_value(evidence: Evidence) -> Reading:
    """Smallest value that is a length [m]."""
    h = evidence.column("d")
    return at(h, int(h.argmin()))


@quantity(N_("smallest h − hₘ"), "", 3, obstacle=True)
def value_margin(evidence: Evidence) -> Reading:
    """Negative if h_m was passed; a number, as several first tasks at once have several units."""
    h = evidence.column("d")
    return at(h - evidence.settings.law.critical_distance, int(h.argmin()))
