"""Every first task on a real arm, in any posture and at later times."""

from collections.abc import Callable

import numpy as np
import pinocchio as pin

from controllers.first_tasks.arms_distance import ArmsDistance
from controllers.first_tasks.centre_of_mass import CentreOfMass, Foot
from controllers.first_tasks.first_task import FirstTask
from controllers.first_tasks.joint_stops import JointStops
from controllers.first_tasks.links_over_boxes import LinkCapsule, LinksOverBoxes
from controllers.first_tasks.own_links import OwnLinks
from controllers.first_tasks.points_over_plane import Plane, PointsOverPlane, landmarks
from controllers.first_tasks.several_at_once import SeveralAtOnce
from controllers.first_tasks.smallest_singular_value import SmallestSingularValue
from controllers.kinematics import Arm, Array
from controllers.row_stage import smooth_stage
from scenes.own_pairs import own_pairs
from scenes.room import Room, World, build_room
from scenes.solo import build_alone
from scenes.surroundings import surroundings

ORDER = 6.0


class PosedTask:
    """A first task and its arm. `joints`: live view of the arm's joints (n,)."""

    def __init__(self, room: Room, make: Callable[[World, Arm], FirstTask]) -> None:
        self.room, self.world, self.arm = room, World(room, 10.0), room.arms[0]
        self.joints = self.world.positions[self.arm.joints]
        self.task = make(self.world, self.arm)
        self.low, self.high = (
            bound[self.arm.joints].copy()
            for bound in (room.model.lowerPositionLimit, room.model.upperPositionLimit)
        )
        wide = self.world.bounds.part(self.arm.joints)
        wide.lower[:], wide.upper[:] = -1e9, 1e9
        self.stage = smooth_stage(self.task, wide, ORDER)

    def at(self, q: Array) -> None:
        """Set the arm's posture (n,)."""
        self.joints[:] = q
        self.world.kinematics.update(self.world.positions)

    def value(self, q: Array) -> float:
        self.at(q)
        return self.task.margin().value

    def value_after(self, q: Array, dq: Array, time: float) -> float:
        """h after `time` [s] at constant velocities, from q (n,) with q̇ (n,); the state is restored."""
        others = self.world.positions.copy()
        task = self.task.tasks[0] if isinstance(self.task, SeveralAtOnce) else self.task
        self.world.positions += self.world.velocities * time
        if isinstance(task, PointsOverPlane):
            plane = task.plane
            turn = pin.exp3(plane.turning * time)
            task.plane = Plane(turn @ plane.normal, plane.point + plane.velocity * time)
            value = self.value(q + dq * time)
            task.plane = plane
        else:
            value = self.value(q + dq * time)
        self.world.positions[:] = others
        self.at(q)
        return value

    def pulled(self, speed: float) -> Array:
        """q̇_n (n,) along J_a that lowers h at `speed`."""
        row = self.task.margin().row
        return row * (-speed / float(row @ row))


def stops(world: World, arm: Arm) -> FirstTask:
    model, j = world.room.model, arm.joints
    return JointStops(world.positions[j], model.lowerPositionLimit[j], model.upperPositionLimit[j])


def wall(world: World, arm: Arm) -> FirstTask:
    normal = np.array([-2.0, 1.0, 1.5]) / np.sqrt(7.25)
    moved = Plane(normal, np.array([0.1, 0.0, 1.1]), np.array([-0.05, 0.02, 0.1]), np.array([0.3, -0.2, 0.5]))
    return PointsOverPlane(world.kinematics, arm, landmarks(world.room.model, arm, 0.03), moved)


def table(world: World, arm: Arm) -> FirstTask:
    still = Plane(np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, 0.75]))
    return PointsOverPlane(world.kinematics, arm, landmarks(world.room.model, arm), still)


def links(world: World, arm: Arm) -> FirstTask:
    return OwnLinks(world.kinematics, arm, own_pairs(world.room, arm, 0.06))


def singular(world: World, arm: Arm) -> FirstTask:
    return SmallestSingularValue(world.kinematics, arm)


def tipping(world: World, arm: Arm) -> FirstTask:
    base = world.room.rig.bases[0].translation
    # The arm is near one edge of its cart.
    cart = Foot(
        base[:2] - np.array([0.09, 0.0]), np.array([0.16, 0.14]), 40.0, base - np.array([0.0, 0.0, 0.4])
    )
    return CentreOfMass(world.kinematics, arm, cart, load=3.0)


def bench(world: World, arm: Arm) -> FirstTask:
    """Three capsules of the arm above a bench and the floor, which some postures overlap."""
    capsules = [
        LinkCapsule(arm.shoulder, np.array([0.0, 0.0, 0.25]), np.array([0.0, 0.0, 0.12]), 0.07),
        LinkCapsule(arm.elbow, np.array([0.0, 0.0, 0.195]), np.array([0.0, 0.0, 0.195]), 0.065),
        LinkCapsule(arm.wrist, np.array([0.0, 0.0, 0.064]), np.array([0.0, 0.0, 0.064]), 0.05),
    ]
    boxes = np.array([[0.1, 0.0, 0.369, 0.5, 0.3, 0.369], [0.0, 0.0, -5.0, 20.0, 20.0, 5.0]])
    return LinksOverBoxes(world.kinematics, arm, capsules, boxes)


def several(world: World, arm: Arm) -> FirstTask:
    return SeveralAtOnce([wall(world, arm), stops(world, arm), tipping(world, arm)], "several", 5.0)


def around(world: World, arm: Arm) -> FirstTask:
    """The arm's own links, the floor and its column."""
    found = surroundings(world, arm)
    assert found is not None
    return found


def arms(world: World, arm: Arm) -> FirstTask:
    world.velocities[world.room.arms[1].joints] = np.linspace(-0.3, 0.4, 7)
    return ArmsDistance(world.detector, arm, world.velocities)


ALONE: dict[str, Callable[[World, Arm], FirstTask]] = {
    "joint stops": stops,
    "a wall that moves and turns": wall,
    "a table": table,
    "own links": links,
    "singular value": singular,
    "centre of mass": tipping,
    "a bench and the floor": bench,
    "several at once": several,
    "surroundings": around,
}
NAMES = (*ALONE, "the other arm")


FOLDED = np.array([-1.4, 2.0, 0.3, -2.0, 2.3, -1.2, -1.8])
"""Posture with the hand in the pedestal, rare among random postures."""


def posed(name: str) -> PosedTask:
    return PosedTask(build_alone(), ALONE[name]) if name in ALONE else PosedTask(build_room("torso"), arms)


def postures(of: PosedTask, count: int, seed: int, beyond: float = 0.0) -> Array:
    """Random postures (count, n), up to `beyond` past the stops [rad]; folded postures for own links."""
    drawn = np.random.default_rng(seed).uniform(of.low - beyond, of.high + beyond, (count, len(of.low)))
    return FOLDED + 0.15 * drawn if isinstance(of.task, OwnLinks) else drawn


def regular(of: PosedTask, q: Array) -> bool:
    """True if h has a unique derivative and |J_a| is at least the task's authority."""
    of.at(q)
    if isinstance(of.task, SmallestSingularValue):
        values = np.linalg.svd(of.world.kinematics.hand_jacobian(of.arm, 3), compute_uv=False)
        if values[1] - values[2] < 0.05 or values[2] < 0.02:
            return False
    return float(np.linalg.norm(of.task.margin().row)) >= of.task.authority
