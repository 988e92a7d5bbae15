"""The whole loop with a pull and an approach that stay the same: both arms, one pair of bodies, the law, the integration.

No experiment keeps u and w constant for long, and the closed forms are about nothing else. So the avoiding arm's task is −u along its
row, and the other arm comes with w along its own; poses, capsules, rows and law are those of every other run.
"""

from typing import NamedTuple

import numpy as np

from controllers import budget
from controllers.kinematics import Array, Kinematics
from controllers.laws.situation import Situation
from controllers.laws.smooth_priority import SmoothPriority
from controllers.proximity import ProximityDetector
from scenes.room import build_room


class Rest(NamedTuple):
    """Where a pull and an approach bring the distance.

    Attributes:
        measured: at the end of the run [m].
        closed_form: d* [m].
    """

    measured: float
    closed_form: float


class ContactRun:
    """Two arms on the table; left avoids with its hand, right comes with its forearm.

    Args:
        law: of the left arm.
    """

    def __init__(self, law: SmoothPriority) -> None:
        room = build_room("table")
        self._law = law
        self._kinematics = Kinematics(room.model, room.arms)
        self._detector = ProximityDetector(self._kinematics, room.geometry)
        self._pair = self._detector.pair_names.index(("left hand", "right forearm"))
        self._left, self._right = room.arms[0].joints, room.arms[1].joints
        self._q = room.start.copy()
        self._row = np.zeros(room.model.nv)

    def measure(self) -> float:
        """Return d of the pair at the present posture [m]."""
        self._kinematics.update(self._q)
        self._detector.detect()
        self._row = self._detector.row(self._pair)
        return float(self._detector.distances()[self._pair])

    def start_at(self, distance: float) -> None:
        """Bring both arms to a distance of the pair [m], by Newton steps along the rows."""
        for _ in range(100):
            missing = distance - self.measure()
            step = min(max(missing, -0.02), 0.02) / 2.0
            for joints in (self._left, self._right):
                self._q[joints] += self._along(joints, step)
            if abs(missing) < 1e-12:
                return

    def run(self, seconds: float, dt: float, pull: float, approach: float) -> float:
        """Return d after some time [m] of a pull u and an approach w [m/s]."""
        distance = self.measure()
        for _ in range(round(seconds / dt)):
            row = self._row[self._left]
            situation = Situation(self._q[self._left], self._along(self._left, -pull), row, distance, approach)
            step = self._law(situation) * dt
            self._q[self._right] += self._along(self._right, -approach) * dt
            self._q[self._left] += step
            distance = self.measure()
        return distance

    def _along(self, joints: slice, speed: float) -> Array:
        """Return the smallest velocity (n,) of an arm that changes d at a speed [m/s]."""
        row = self._row[joints]
        return row * (speed / row.dot(row))


def rest(law: SmoothPriority, pull: float, approach: float, dt: float = 0.005) -> Rest:
    """Return where d settles; the run starts 15 mm beyond and lasts five time constants, at most 10 s."""
    closed = budget.resting_distance(law.critical_distance, law.order, law.nominal_velocity, pull, approach)
    contact = ContactRun(law)
    contact.start_at(closed + 0.015)
    tau = budget.settling_time(law.critical_distance, law.order, law.nominal_velocity, pull, approach)
    return Rest(contact.run(min(5.0 * tau, 10.0), dt, pull, approach), closed)
