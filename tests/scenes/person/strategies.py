"""Random postures of a person."""

import numpy as np
from hypothesis import strategies as st

from controllers.kinematics import Array
from scenes.settings import ArmName

SIDES: tuple[ArmName, ArmName] = ("left", "right")


def _arm(abduction: tuple[float, float], elbow: tuple[float, float]) -> st.SearchStrategy[Array]:
    ranges = ((-60.0, 179.0), abduction, (-100.0, 100.0), elbow)
    return st.tuples(*(st.floats(low, high, width=32) for low, high in ranges)).map(
        lambda arm: np.radians(np.array(arm))
    )


arms = _arm((-89.0, 89.0), (0.0, 150.0))
"""Any posture of one arm."""

plain_arms = _arm((-80.0, 80.0), (10.0, 110.0))
"""Postures off the T with a bent elbow: four observable angles within reach of a robot's elbow."""


def bodies(one_arm: st.SearchStrategy[Array]) -> st.SearchStrategy[Array]:
    """Both arms (2, 4), left first."""
    return st.tuples(one_arm, one_arm).map(np.array)
