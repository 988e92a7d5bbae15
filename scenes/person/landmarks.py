"""MediaPipe's 33 pose landmarks → a person's angles."""

from typing import Final

import numpy as np

from controllers.kinematics import Array
from scenes.person.angles import BodyPoints, body_angles

COUNT: Final = 33

SHOULDERS: Final = (11, 12)
ELBOWS: Final = (13, 14)
WRISTS: Final = (15, 16)
HIPS: Final = (23, 24)
"""Indices of MediaPipe Pose, the person's left first."""

ARMS: Final = (*SHOULDERS, *ELBOWS, *WRISTS)

LEAST_VISIBILITY: Final = 0.5
"""A landmark less visible than this is not looked at; 0 … 1."""

SHORTEST_BONE: Final = 0.03
"""No bone of a tracked person is shorter [m]; a shorter one is a mistake of the tracking."""


def landmarks_to_angles(landmarks: Array, visibility: Array, previous: Array | None = None) -> Array | None:
    """Return the angles (2, 4) of both arms [rad], left first; None unless shoulders, elbows and wrists are visible.

    Without hips, as of a person at a desk, the body is taken to be upright in the picture.

    Args:
        landmarks: "world landmarks" (33, 3): x right in the picture, y down, z away from the camera [m].
        visibility: of each (33,), 0 … 1.
        previous: the angles of the sample before (2, 4) [rad]; None for the first one.
    """
    arms = landmarks[list(ARMS)]
    if not (visibility[list(ARMS)] >= LEAST_VISIBILITY).all() or not np.isfinite(arms).all():
        return None
    shoulders, elbows, wrists = arms[:2], arms[2:4], arms[4:]
    for a, b in ((shoulders, elbows), (elbows, wrists)):
        if (np.linalg.norm(b - a, axis=1) < SHORTEST_BONE).any():
            return None
    hips = landmarks[list(HIPS)].mean(axis=0)
    if not ((visibility[list(HIPS)] >= LEAST_VISIBILITY).all() and np.isfinite(hips).all()):
        hips = shoulders.mean(axis=0) + np.array([0.0, 0.5, 0.0])
    return body_angles(BodyPoints(shoulders, elbows, wrists, hips), previous)
