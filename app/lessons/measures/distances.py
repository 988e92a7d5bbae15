"""How near the obstacle came, and how fast."""

import numpy as np

from app.lessons.evidence import Evidence
from app.lessons.measures.quantity import Value, quantity


def has_obstacle(evidence: Evidence) -> bool:
    """Return whether there is something to keep clear of, and a step was made."""
    return evidence.rows > 0 and bool(np.isfinite(evidence.column("d")).any())


@quantity("distance now", "m", "mm", 0, live=True)
def distance_now(evidence: Evidence) -> Value:
    """Return d in the newest step [m]."""
    return float(evidence.column("d")[-1]) if has_obstacle(evidence) else None


@quantity("smallest distance", "m", "mm", 1)
def smallest_distance(evidence: Evidence) -> Value:
    """Return the smallest d of the run [m]."""
    return float(evidence.column("d").min()) if has_obstacle(evidence) else None


@quantity("smallest d − d_m", "m", "mm", 1)
def distance_margin(evidence: Evidence) -> Value:
    """Return the smallest d of the run less d_m [m]; negative if the critical distance was passed."""
    smallest = smallest_distance(evidence)
    return None if smallest is None else smallest - evidence.settings.law.critical_distance


@quantity("distance at {time}", "m", "mm", 1)
def distance_at(evidence: Evidence, time: float) -> Value:
    """Return d at a time [m]."""
    row = evidence.row_at(time)
    return float(evidence.column("d")[row]) if row is not None and has_obstacle(evidence) else None


@quantity("way made towards the obstacle", "m", "mm", 1)
def way_made(evidence: Evidence, since: float, until: float) -> Value:
    """Return d(since) − d(until) [m]."""
    begin, end = distance_at(evidence, since), distance_at(evidence, until)
    return None if begin is None or end is None else begin - end


@quantity("fastest approach of the obstacle", "m/s", "m/s", 2)
def largest_approach(evidence: Evidence, within: float = 10.0) -> Value:
    """Return the largest w while d was less than `within` [m/s]."""
    if not has_obstacle(evidence):
        return None
    near = evidence.column("d") < within
    return float(evidence.column("w")[near].max()) if near.any() else None


@quantity("approach of the obstacle now", "m/s", "m/s", 2, live=True)
def approach_now(evidence: Evidence) -> Value:
    """Return w in the newest step [m/s]."""
    return float(evidence.column("w")[-1]) if has_obstacle(evidence) else None


@quantity("changes of the closest pair", "", "", 0)
def pair_switches(evidence: Evidence) -> Value:
    """Return how often another pair of bodies became the closest."""
    return float(np.count_nonzero(np.diff(evidence.column("pair")))) if has_obstacle(evidence) else None
