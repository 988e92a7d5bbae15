"""Distance from joint stops and singular postures."""

import numpy as np

from app.features.measures.evidence import Evidence
from app.features.measures.quantities.quantity import At, Reading, at, quantity
from app.i18n.speaking import N_


@quantity(N_("smallest way to a joint stop"), "deg", 1)
def way_to_stops(evidence: Evidence) -> Reading:
    model, j = evidence.room.model, evidence.arm.joints
    q = evidence.positions[:, j]
    ways = np.minimum(q - model.lowerPositionLimit[j], model.upperPositionLimit[j] - q).min(axis=1)
    return at(ways, int(ways.argmin()))


@quantity(N_("smallest singular value of J"), "m/rad", 3)
def singular_value(evidence: Evidence) -> Reading:
    """Of the hand's place; 0 for a stretched arm."""
    values = evidence.along(
        lambda row: np.linalg.svd(
            evidence.kinematics_at(row).hand_jacobian(evidence.arm, 3), compute_uv=False
        )[-1]
    )
    return At(float(values.min()), evidence.sampled_rows()[int(values.argmin())])
