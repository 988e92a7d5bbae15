"""One arm's own links, fixed capsules and fixed boxes in one loop.

    h = −ln Σ exp(−β m_i) / β,      J_a = Σ p_i n_iᵀ J_i,

over every meeting i: of two capsules as in `controllers.convex_distance`, of a capsule and a box as in
`links_over_boxes`. Faster than `OwnLinks` and `LinksOverBoxes`: meetings far from the nearest one are left
out.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from controllers.activation import activation as plain_activation
from controllers.compiled import IndexPairs, Matrix, Vector, loop
from controllers.convex_distance import convex_closest
from controllers.first_tasks.first_task import FirstTask, Margin
from controllers.first_tasks.joint_placements import JointPlacements, Moved
from controllers.first_tasks.links_over_boxes import LinkCapsule, capsule_over_box
from controllers.kinematics import Array, Kinematics
from controllers.laws.situation import row_damping as plain_row_damping

SHARPNESS: Final = 100.0
"""β [1/m]."""

ROUNDING: Final = 0.010
"""κ over boxes [m]: at most 2.5 mm of distance."""

CONVEXITY: Final = 1e-4
"""ε between capsules [m²]: at most 7 mm of distance."""

FAR: Final = 0.2
"""Meetings farther than the nearest one by this are left out [m]: their share is below 3e-9."""

activation = loop("float64(float64, float64, float64)")(plain_activation)
row_damping = loop("float64(float64)")(plain_row_damping)
"""The usual functions, inside a loop."""


@loop(
    "float64(float64[:, :], float64[:, :], int64[:, :], float64[:, :], float64[:, :], float64[:, :], float64[:])",
    fills=("contacts", "row"),
)
def margin_of_all(
    placements: Matrix,
    bodies: Matrix,
    meetings: IndexPairs,
    boxes: Matrix,
    jacobian: Matrix,
    contacts: Matrix,
    row: Vector,
) -> float:
    """Fill J_a (n,) [m/rad] and every contact; return h [m].

    Args:
        placements: of the joints that carry bodies (j, 12), see `JointPlacements`.
        bodies: unit axis, centre [m], half length [m], radius [m], in the frame of the row of `placements`
            that follows; −1 for the world (k, 9).
        meetings: first body; second body, or box b as −1 − b; first and end column of J of the joints that
            change their distance (m, 4).
        boxes: centres and half sizes (b, 6), world [m].
        jacobian: the arm's columns (6, n), see `Kinematics`.
        contacts: margin, point and direction of the line of contact, away from the other body (m, 7).
    """
    frames, n = np.empty((len(bodies), 6)), len(row)
    for k in range(len(bodies)):
        own, carrier = bodies[k], int(bodies[k, 8])
        if carrier < 0:
            for i in range(6):
                frames[k, i] = own[i]
        else:
            for i in range(3):
                x, y, z = placements[carrier, i], placements[carrier, 3 + i], placements[carrier, 6 + i]
                frames[k, i] = x * own[0] + y * own[1] + z * own[2]
                frames[k, 3 + i] = x * own[3] + y * own[4] + z * own[5] + placements[carrier, 9 + i]
    least, inside = math.inf, math.sqrt(0.5 * CONVEXITY)
    for i in range(len(meetings)):
        a, b = int(meetings[i, 0]), int(meetings[i, 1])
        f, half, radius = frames[a], bodies[a, 6], bodies[a, 7]
        if b >= 0:
            px, py, pz, gx, gy, gz, D = convex_closest(f, frames[b], half, bodies[b, 6], CONVEXITY)
            m, gx, gy, gz = D - inside - (radius + bodies[b, 7]), gx / D, gy / D, gz / D
        else:
            ax, ay, az = half * f[0], half * f[1], half * f[2]
            m, px, py, pz, gx, gy, gz = capsule_over_box(
                f[3], f[4], f[5], ax, ay, az, radius, ROUNDING, boxes[-1 - b]
            )
        contacts[i, 0], contacts[i, 1], contacts[i, 2], contacts[i, 3] = m, px, py, pz
        contacts[i, 4], contacts[i, 5], contacts[i, 6] = gx, gy, gz
        least = min(least, m)
    row[:] = 0.0
    total = 0.0
    for i in range(len(meetings)):
        beyond = contacts[i, 0] - least
        if beyond < FAR:
            weight = math.exp(-SHARPNESS * beyond)
            total += weight
            px, py, pz = contacts[i, 1], contacts[i, 2], contacts[i, 3]
            nx, ny, nz = weight * contacts[i, 4], weight * contacts[i, 5], weight * contacts[i, 6]
            mx, my, mz = py * nz - pz * ny, pz * nx - px * nz, px * ny - py * nx
            for j in range(meetings[i, 2], meetings[i, 3]):
                linear = nx * jacobian[0, j] + ny * jacobian[1, j] + nz * jacobian[2, j]
                row[j] += linear + mx * jacobian[3, j] + my * jacobian[4, j] + mz * jacobian[5, j]
    for j in range(n):
        row[j] /= total
    return least - math.log(total) / SHARPNESS


@loop(
    "boolean(float64[:, :], float64[:, :], int64[:, :], float64[:, :], float64[:, :], float64[:, :], float64[:],"
    " float64, float64, float64, float64[:], float64[:], float64[:])",
    fills=("contacts", "row", "velocities"),
)
def keep_clear(
    placements: Matrix,
    bodies: Matrix,
    meetings: IndexPairs,
    boxes: Matrix,
    jacobian: Matrix,
    contacts: Matrix,
    row: Vector,
    critical_value: float,
    order: float,
    nominal_rate: float,
    lower: Vector,
    upper: Vector,
    velocities: Vector,
) -> bool:
    """Replace q̇_n (n,) by q̇ of the one-sided law, eq. (32) [rad/s]; False, with q̇_n unchanged, if q̇ is
    outside the bounds.

    Args:
        placements, bodies, meetings, boxes, jacobian, contacts, row: see `margin_of_all`.
        critical_value, nominal_rate: h_m [m], v [m/s].
        order: n.
        lower, upper: (n,) [rad/s].
    """
    h = margin_of_all(placements, bodies, meetings, boxes, jacobian, contacts, row)
    square = rate = 0.0
    for j in range(len(row)):
        square += row[j] * row[j]
        rate += row[j] * velocities[j]
    if rate >= nominal_rate:
        return True
    c = activation(h, critical_value, order) * (nominal_rate - rate) / (square + row_damping(square))
    for j in range(len(row)):
        if not lower[j] <= velocities[j] + c * row[j] <= upper[j]:
            return False
    for j in range(len(row)):
        velocities[j] += c * row[j]
    return True


@dataclass(frozen=True)
class Meeting:
    """Two capsules, or a capsule and a box, that can meet.

    Attributes:
        first, second: indices of capsules; `second` of a box if `over_box`.
    """

    first: int
    second: int
    over_box: bool = False


class Surroundings(FirstTask):
    """h: smooth minimum of the distances of an arm from its own links, fixed capsules and boxes [m].

    Args:
        moved: the arm, or the ball.
        joints: ids, from the base outward.
        capsules: of the arm, or fixed: with joint 0, in the world frame.
        meetings: at least one.
        boxes: centres and half sizes (b, 6), world axes [m].
    """

    name = "distance from table, stand and itself"
    unit = "m"

    def __init__(
        self,
        kinematics: Kinematics,
        moved: Moved,
        joints: Sequence[int],
        names: Sequence[str],
        capsules: Sequence[LinkCapsule],
        meetings: Sequence[Meeting],
        boxes: Array,
        critical_value: float = 0.03,
        nominal_rate: float = 0.05,
    ) -> None:
        super().__init__(critical_value, nominal_rate)
        model, columns = kinematics.model, moved.joints
        self._placements = JointPlacements(kinematics, moved, joints)
        carriers = [joints.index(capsule.joint) if capsule.joint else -1 for capsule in capsules]
        ends = [model.joints[joint].idx_v + model.joints[joint].nv - columns.start for joint in joints]
        counts = [ends[carrier] if carrier >= 0 else 0 for carrier in carriers]
        self.names, self.capsules = tuple(names), tuple(capsules)
        self.meetings = tuple(meetings)
        self._bodies = np.array([_body(capsule, at) for capsule, at in zip(capsules, carriers, strict=True)])
        self._moving = counts
        self._meetings = np.array([_indices(meeting, counts) for meeting in meetings], np.int64)
        self._boxes, self._jacobian = boxes, kinematics.jacobian[:, columns]
        self.contacts = np.empty((len(meetings), 7))
        """See `margin_of_all`; filled by each call."""
        self._row = np.empty(self._jacobian.shape[1])
        self._seen = (
            self._placements.read(),
            self._bodies,
            self._meetings,
            self._boxes,
            self._jacobian,
            self.contacts,
        )

    def margin(self) -> Margin:
        self._placements.read()
        row = np.empty(len(self._row))
        return Margin(margin_of_all(*self._seen, row), row)

    def inner_of(self, meeting: Meeting) -> int:
        """Capsule of a pair that fewer joints move; the point in `contacts` is on its axis."""
        return min(meeting.second, meeting.first, key=lambda capsule: self._moving[capsule])

    def law(self, order: float, lower: Array, upper: Array) -> Callable[[Array], bool]:
        """Law of `keep_clear`: it replaces q̇_n (n,) in place.

        Args:
            lower, upper: live bounds of q̇ (n,) [rad/s].
        """
        read = self._placements.read
        given = *self._seen, self._row, self.critical_value, order, self.nominal_rate, lower, upper

        def keep(velocities: Array) -> bool:
            read()
            return keep_clear(*given, velocities)

        return keep


def _body(capsule: LinkCapsule, carrier: int) -> list[float]:
    half = float(np.linalg.norm(capsule.half_axis))
    axis = capsule.half_axis / half if half else np.array([0.0, 0.0, 1.0])
    return [*axis, *capsule.centre, half, capsule.radius, carrier]


def _indices(meeting: Meeting, moving: Sequence[int]) -> tuple[int, int, int, int]:
    """Row of `meetings` of `margin_of_all`; `moving`: number of columns that move each capsule."""
    first, second = meeting.first, meeting.second
    if meeting.over_box:
        return first, -1 - second, 0, moving[first]
    # The columns beyond the inner one move the outer one alone, away from it along the line of contact.
    if moving[first] > moving[second]:
        first, second = second, first
    return first, second, moving[first], moving[second]
