"""The distance of two arms, the first task of Petrič & Žlajpah 2011, eqs (26), (27).

h = d_law,      J_a = the arm's own columns of J_d,      w = −Σ J_d,j q̇_j over all other joints.
"""

from controllers.choices import Treatment
from controllers.first_tasks.first_task import FirstTask, Margin
from controllers.kinematics import Arm, Array
from controllers.proximity import ProximityDetector


class ArmsDistance(FirstTask):
    """h: distance of an arm from the other one [m].

    Args:
        arm: the one that avoids.
        velocities: q̇ (nv,) of everything that moves, a live view [rad/s].
        treatment, beta, epsilon: see `ProximityDetector.detect`.
    """

    name = "distance of the arms"
    unit = "m"

    def __init__(
        self,
        detector: ProximityDetector,
        arm: Arm,
        velocities: Array,
        treatment: Treatment = "smooth",
        beta: float = 100.0,
        epsilon: float = 1e-4,
        critical_value: float = 0.15,
        nominal_rate: float = 0.3,
    ) -> None:
        super().__init__(critical_value, nominal_rate)
        self._detector, self._joints, self._velocities = detector, arm.joints, velocities
        self._seen: tuple[Treatment, float, float] = treatment, beta, epsilon

    def margin(self) -> Margin:
        near = self._detector.detect(*self._seen)
        row = near.row[self._joints].copy()
        w = float(row.dot(self._velocities[self._joints])) - float(near.row.dot(self._velocities))
        return Margin(near.law_distance, row, w)
