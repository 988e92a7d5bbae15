"""What a robot that answers late makes of the distance."""

import numpy as np

from app.lessons.evidence import Evidence
from app.lessons.measures.distances import has_obstacle
from app.lessons.measures.quantity import Value, quantity
from controllers import budget


@quantity("swing of d, {since} to {until}", "m", "mm", 1)
def distance_swing(evidence: Evidence, since: float, until: float) -> Value:
    """Return the largest less the smallest d between two times [m]."""
    if not has_obstacle(evidence) or evidence.row_at(until) is None:
        return None
    d = evidence.column("d")[(evidence.times >= since - 1e-9) & (evidence.times <= until + 1e-9)]
    return float(np.ptp(d)) if len(d) else None


@quantity("a T at {time}, T = {dead}", "", "", 2)
def dead_time_number(evidence: Evidence, time: float, dead: float) -> Value:
    """Return a T = n (u + w) T / d* with u and w of the step at a time, for a dead time T [s]: a rest is stable below π/2."""
    row = evidence.row_at(time)
    if row is None or not has_obstacle(evidence):
        return None
    law, u, w = evidence.settings.law, float(evidence.column("u")[row]), float(evidence.column("w_law")[row])
    v = law.nominal_velocity + (w if law.feed_forward else 0.0)
    return dead / budget.settling_time(law.critical_distance, law.order, v, u, w)
