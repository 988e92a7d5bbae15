"""Runs of one arm with a first task."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from controllers.activation import activation
from controllers.budget import distance_rate
from controllers.first_tasks.centre_of_mass import CentreOfMass, Foot
from controllers.first_tasks.first_task import FirstTask, Margin
from controllers.first_tasks.joint_stops import JointStops
from controllers.first_tasks.own_links import OwnLinks
from controllers.first_tasks.points_over_plane import Plane, PointsOverPlane, landmarks
from controllers.first_tasks.smallest_singular_value import SmallestSingularValue
from controllers.kinematics import Arm, Array
from controllers.limits import VelocityBox
from controllers.row_stage import smooth_stage
from controllers.tasks import hold, position_error
from scenes.own_pairs import own_pairs
from scenes.room import World
from scenes.solo import build_alone
from scenes.targets import quintic

ORDER: Final = 6.0
"""n of the law."""

GAIN: Final = 2.0
"""K of the hand's task [1/s]."""

SPEED: Final = 0.2
"""Mean speed of the hand's target [m/s]."""

SPREAD: Final = 0.02
"""Range of random offsets from a case's places, per axis [m]."""

STEP: Final = 0.005
"""dt [s]."""

PERIOD: Final = 0.05
"""Simulated time between two rows [s]."""

DIFFERENCE: Final = 2e-5
"""Time step of the differences for ḣ [s]."""

WALL_SPEED: Final = 0.01
"""w of the wall [m/s]."""

WALL: Final = Plane(np.array([-1.0, 0.0, 0.0]), np.array([0.15, 0.0, 0.0]), np.array([-WALL_SPEED, 0.0, 0.0]))

LINK_GAP: Final = 0.06
"""Own links nearer than this at the start are not paired [m]."""

CART_HALF: Final = 0.18
CART_MASS: Final = 20.0
"""Half width of a square cart [m], and its mass [kg]."""

LOAD: Final = 3.0
"""Mass in the hand [kg]."""


@dataclass(frozen=True)
class FirstTaskCase:
    """A first task, and targets of the hand (k, 3), world [m]; it returns home after each."""

    name: str
    title: str
    make: Callable[[World, Arm], FirstTask]
    places: Sequence[tuple[float, float, float]]


def joint_stops(world: World, arm: Arm) -> FirstTask:
    model, j = world.room.model, arm.joints
    return JointStops(world.positions[j], model.lowerPositionLimit[j], model.upperPositionLimit[j])


def wall(world: World, arm: Arm) -> FirstTask:
    return PointsOverPlane(world.kinematics, arm, landmarks(world.room.model, arm), WALL)


def own_links(world: World, arm: Arm) -> FirstTask:
    return OwnLinks(world.kinematics, arm, own_pairs(world.room, arm, LINK_GAP))


def singular_value(world: World, arm: Arm) -> FirstTask:
    return SmallestSingularValue(world.kinematics, arm)


def centre_of_mass(world: World, arm: Arm) -> FirstTask:
    base = world.room.rig.bases[0].translation
    cart = Foot(base[:2], np.full(2, CART_HALF), CART_MASS, base - np.array([0.0, 0.0, 0.4]))
    return CentreOfMass(world.kinematics, arm, cart, LOAD)


CASES: Final = (
    FirstTaskCase("joint_stops", "way to the stops", joint_stops, ((-0.1, 0.0, 1.15), (-0.35, 0.25, 1.0))),
    FirstTaskCase("plane", "distance from a wall", wall, ((0.35, 0.0, 1.4), (0.3, 0.3, 1.2))),
    FirstTaskCase("own_links", "distance of own links", own_links, ((-0.4, 0.05, 0.95),)),
    FirstTaskCase(
        "singular_value", "smallest singular value", singular_value, ((0.75, 0.0, 1.3), (0.5, 0.5, 1.3))
    ),
    FirstTaskCase(
        "centre_of_mass", "centre of mass in the foot", centre_of_mass, ((0.5, 0.0, 1.1), (0.3, 0.4, 1.0))
    ),
)


@dataclass(frozen=True)
class Moment:
    """Record of one step.

    Attributes:
        time: [s].
        lam: λ; 0 without the law.
        u: −J_a q̇_n [unit/s].
        rate: ḣ by differences of h along q̇ [unit/s].
        closed_form: ḣ = λ v − (1 − λ) u − w [unit/s].
        exact: True if no top speed and no damping of J_a^# acts: then both are equal.
    """

    time: float
    margin: Margin
    lam: float
    u: float
    rate: float
    closed_form: float
    exact: bool


class FirstTaskRun:
    """One arm, a person who moves its hand, and a first task.

    Joints may pass their stops, so that only the first task acts; top speeds hold.

    Args:
        seed: varies the person's targets.
    """

    def __init__(self, case: FirstTaskCase, law: bool, seed: int) -> None:
        room, random = build_alone(), np.random.default_rng(seed)
        self._world, self._arm, self._law = World(room, 1.0), room.arms[0], law
        self._kinematics, self._joints = self._world.kinematics, self._world.positions[self._arm.joints]
        self._world.update()
        self.task = case.make(self._world, self._arm)
        n = len(self._joints)
        endless, self._top = np.full(n, np.inf), room.model.velocityLimit[self._arm.joints].copy()
        self._stage = smooth_stage(self.task, VelocityBox(-endless, endless, self._top, 1.0), ORDER)
        self._bend, self._pose = room.bend(self._arm), self._kinematics.hand_pose(self._arm)
        home, points = self._pose.translation.copy(), [self._pose.translation.copy()]
        for place in case.places:
            points += [np.array(place) + random.uniform(-SPREAD, SPREAD, 3), home]
        self._points = np.array(points)
        ways = np.linalg.norm(np.diff(self._points, axis=0), axis=1)
        self._times = np.concatenate([[0.0], np.cumsum(ways / SPEED)])

    def moments(self) -> list[Moment]:
        found: list[Moment] = []
        every = round(PERIOD / STEP)
        for step in range(round(float(self._times[-1]) / STEP) + 1):
            time = step * STEP
            self._move_wall(time)
            self._world.update()
            nominal = self._stage.box.clip(self._nominal(time))
            dq = self._stage(nominal) if self._law else nominal
            if step % every == 0:
                found.append(self._moment(time, nominal, dq))
            self._joints += dq * STEP
        return found

    def _nominal(self, time: float) -> Array:
        """q̇_n of the hand's task, eq. (7) (n,) [rad/s]."""
        leg = min(int(np.searchsorted(self._times, time, side="right")), len(self._times) - 1) - 1
        begin, duration = self._times[leg], self._times[leg + 1] - self._times[leg]
        share, speed = quintic(min((time - begin) / duration, 1.0))
        way = self._points[leg + 1] - self._points[leg]
        J = self._kinematics.hand_jacobian(self._arm, 3)
        error = position_error(self._pose, self._points[leg] + way * share)
        return hold(J, error, GAIN, way * (speed / duration), bend=self._bend)

    def _moment(self, time: float, nominal: Array, dq: Array) -> Moment:
        margin = self.task.margin()
        u = -float(margin.row @ nominal)
        lam = activation(margin.value, self.task.critical_value, ORDER) if self._law else 0.0
        regular = not self._law or float(np.linalg.norm(margin.row)) >= self.task.authority
        exact = regular and bool((np.abs(dq) < self._top).all())
        closed_form = distance_rate(lam, self.task.nominal_rate, u, margin.approach)
        return Moment(time, margin, lam, u, self._rate(time, dq), closed_form, exact)

    def _rate(self, time: float, dq: Array) -> float:
        """ḣ by central differences of fourth order, with the wall's motion [unit/s]."""
        at, t = self._joints.copy(), DIFFERENCE
        h: list[float] = []
        for way in (-2.0 * t, -t, t, 2.0 * t):
            self._joints[:] = at + dq * way
            self._move_wall(time + way)
            self._kinematics.update(self._world.positions)
            h.append(self.task.margin().value)
        self._joints[:] = at
        self._move_wall(time)
        self._kinematics.update(self._world.positions)
        return (8.0 * (h[2] - h[1]) - (h[3] - h[0])) / (12.0 * t)

    def _move_wall(self, time: float) -> None:
        if isinstance(self.task, PointsOverPlane):
            self.task.plane = replace(WALL, point=WALL.point + WALL.velocity * time)
