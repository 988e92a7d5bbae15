"""An arm's own links, and fixed capsules near it: the smooth minimum over pairs that are not neighbours.

    h = −ln Σ exp(−β d_i) / β,      J_a = Σ p_i nᵀ (J_Q − J_P),

with d_i the distance of `controllers.convex_distance`, P and Q the nearest points and n the line from P to Q.
Far from each other J_a may be nearly 0, like λ.

Source: self-collision as a task in Sugiura, Gienger, Janssen & Goerick, IROS 2007; row by eqs (26), (27),
Petrič & Žlajpah 2011.
"""

from typing import Final

import numpy as np
import pinocchio as pin

from controllers.first_tasks.first_task import FirstTask, Margin
from controllers.kinematics import Arm, Kinematics
from controllers.proximity import ConvexPairs, pair_signs

SHARPNESS: Final = 100.0
"""β [1/m]: for three pairs h is at most 11 mm below the least distance."""

ROUNDING: Final = 1e-4
"""ε [m²]; h is at most 7 mm further below."""


class OwnLinks(FirstTask):
    """h: smooth minimum of the distances of one arm's capsules from its own, or from fixed ones [m].

    Args:
        geometry: bodies and at least one pair.
    """

    name = "distance of its own links"
    unit = "m"

    def __init__(
        self,
        kinematics: Kinematics,
        arm: Arm,
        geometry: pin.GeometryModel,
        critical_value: float = 0.05,
        nominal_rate: float = 0.3,
    ) -> None:
        super().__init__(critical_value, nominal_rate)
        self._model, self._data = kinematics.model, kinematics.data
        self._geometry, self._placed = geometry, geometry.createData()
        signs = np.ascontiguousarray(pair_signs(kinematics, geometry)[:, arm.joints])
        self._pairs = ConvexPairs(kinematics, geometry, self._placed, signs, arm.joints)
        self._count = signs.shape[1]

    def margin(self) -> Margin:
        pin.updateGeometryPlacements(self._model, self._data, self._geometry, self._placed)
        row = np.empty(self._count)
        return Margin(self._pairs.fill(SHARPNESS, ROUNDING, row), row)
