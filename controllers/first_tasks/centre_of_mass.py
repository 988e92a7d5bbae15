"""Not to tip over: the centre of mass of an arm, its load and its base stays over the foot.

    c = (Σ m_i c_i + m_foot c_foot) / M,      m_k = n_k · (c − o_k),      h = −ln Σ exp(−β m_k) / β,

over the edges k of the foot, with the horizontal inward unit normal n_k and a point o_k of the edge. The row
is J_a = Σ p_k n_kᵀ J_c. With D_j and S_j the mass beyond joint j and its Σ m_i c_i, and (v_j, z_j) the column
of the spatial Jacobian at the world's origin,

    J_c,j = (D_j v_j + z_j × S_j) / M.

Statics only: gravity acts along −z. KUKA publishes no masses; those of `scenes.lwr.facts` are estimates.

Sources: outlook of Petrič & Žlajpah 2011 ("maintaining stability of a humanoid"); J_c in Sugihara, Nakamura &
Inoue, ICRA 2002.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from controllers.compiled import Matrix, Vector, loop
from controllers.first_tasks.first_task import FirstTask, Margin
from controllers.first_tasks.joint_placements import JointPlacements
from controllers.kinematics import Arm, Array, Kinematics

SHARPNESS: Final = 100.0
"""β [1/m]: for four edges h is at most 14 mm below the least distance."""


@dataclass(frozen=True, eq=False)
class Foot:
    """Rectangle on the ground under an arm, and the mass that no joint moves.

    Attributes:
        centre: (2,), world x and y [m].
        half: half sizes along x and y (2,) [m].
        mass: [kg].
        centre_of_mass: (3,), world [m].
    """

    centre: Array
    half: Array
    mass: float
    centre_of_mass: Array

    def edges(self) -> Array:
        """Inward normal (x, y) and n · o [m] of every edge (4, 3)."""
        (x, y), (a, b) = self.centre.tolist(), self.half.tolist()
        return np.array([[1.0, 0.0, x - a], [-1.0, 0.0, -x - a], [0.0, 1.0, y - b], [0.0, -1.0, -y - b]])


@loop(
    "float64(float64[:, :], float64[:, :], float64[:], float64[:], float64[:, :], float64[:, :], float64, float64[:])",
    fills=("row",),
)
def centre_over_foot(
    placements: Matrix,
    centres: Matrix,
    masses: Vector,
    fixed: Vector,
    jacobian: Matrix,
    edges: Matrix,
    beta: float,
    row: Vector,
) -> float:
    """h [m]; fills J_a (n,) [m/rad].

    Args:
        placements: of all joints of the arm, see `JointPlacements` (n, 12).
        centres, masses: of the link behind each joint, in its frame (n, 3) [m], (n,) [kg].
        fixed: fixed mass [kg] and its first moment [kg m] (4,).
        jacobian: the arm's columns (6, n), see `Kinematics`.
        edges: see `Foot.edges` (k, 3).
        beta: β [1/m].
    """
    n = len(row)
    # D_j and S_j of what is beyond each joint, from the hand inward.
    beyond = np.empty((n, 4))
    mass = sx = sy = sz = 0.0
    for j in range(n - 1, -1, -1):
        M, c, m = placements[j], centres[j], masses[j]
        mass += m
        sx += m * (M[0] * c[0] + M[3] * c[1] + M[6] * c[2] + M[9])
        sy += m * (M[1] * c[0] + M[4] * c[1] + M[7] * c[2] + M[10])
        sz += m * (M[2] * c[0] + M[5] * c[1] + M[8] * c[2] + M[11])
        beyond[j, 0], beyond[j, 1], beyond[j, 2], beyond[j, 3] = mass, sx, sy, sz
    total = mass + fixed[0]
    x, y = (sx + fixed[1]) / total, (sy + fixed[2]) / total
    least = math.inf
    for k in range(len(edges)):
        least = min(least, edges[k, 0] * x + edges[k, 1] * y - edges[k, 2])
    weights = nx = ny = 0.0
    for k in range(len(edges)):
        weight = math.exp(beta * (least - (edges[k, 0] * x + edges[k, 1] * y - edges[k, 2])))
        weights += weight
        nx += weight * edges[k, 0]
        ny += weight * edges[k, 1]
    nx, ny = nx / weights, ny / weights
    for j in range(n):
        zx, zy, zz = jacobian[3, j], jacobian[4, j], jacobian[5, j]
        along_x = beyond[j, 0] * jacobian[0, j] + zy * beyond[j, 3] - zz * beyond[j, 2]
        along_y = beyond[j, 0] * jacobian[1, j] + zz * beyond[j, 1] - zx * beyond[j, 3]
        row[j] = (nx * along_x + ny * along_y) / total
    return least - math.log(weights) / beta


class CentreOfMass(FirstTask):
    """h: smooth minimum of the horizontal distances of the centre of mass from the foot's edges [m].

    Args:
        load: mass in the hand [kg].
    """

    name = "centre of mass inside the foot"
    unit = "m"
    authority = 0.03
    """A joint of a light arm moves the centre only a little."""

    def __init__(
        self,
        kinematics: Kinematics,
        arm: Arm,
        foot: Foot,
        load: float = 0.0,
        critical_value: float = 0.10,
        nominal_rate: float = 0.10,
    ) -> None:
        super().__init__(critical_value, nominal_rate)
        model = kinematics.model
        joints = [arm.joint(number) for number in range(1, arm.joints.stop - arm.joints.start + 1)]
        self._placements = JointPlacements(kinematics, arm, joints)
        self._masses = np.array([model.inertias[joint].mass for joint in joints])
        self._centres = np.array([model.inertias[joint].lever for joint in joints])
        if load > 0.0:
            hand = model.frames[arm.hand]
            carrier = joints.index(hand.parentJoint)
            moment = self._masses[carrier] * self._centres[carrier] + load * hand.placement.translation
            self._masses[carrier] += load
            self._centres[carrier] = moment / self._masses[carrier]
        self._fixed = np.concatenate(((foot.mass,), foot.mass * foot.centre_of_mass))
        self.foot, self._edges = foot, foot.edges()
        self._jacobian = kinematics.jacobian[:, arm.joints]

    def margin(self) -> Margin:
        row = np.empty(self._jacobian.shape[1])
        links = self._placements.read(), self._centres, self._masses
        return Margin(centre_over_foot(*links, self._fixed, self._jacobian, self._edges, SHARPNESS, row), row)

    def centre(self) -> Array:
        """Total centre of mass (3,), world [m]."""
        placed = self._placements.read()
        moved = sum(
            m * (M[:9].reshape(3, 3).T @ c + M[9:])
            for M, c, m in zip(placed, self._centres, self._masses, strict=True)
        )
        whole: Array = (moved + self._fixed[1:]) / (float(self._masses.sum()) + float(self._fixed[0]))
        return whole

    def ground_points(self) -> tuple[Array, Array]:
        """Centre of mass and the nearest edge point of the foot, both on the ground (3,), world [m]."""
        x, y = self.centre()[:2].tolist()
        margins = self._edges[:, :2] @ np.array([x, y]) - self._edges[:, 2]
        k = int(margins.argmin())
        edge = np.array([x, y]) - self._edges[k, :2] * margins[k]
        return np.array([x, y, 0.0]), np.array([*edge, 0.0])
