"""Model of everything that moves in a room, and its state."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import Final

import coal
import numpy as np
import pinocchio as pin

from controllers.choices import HandTask
from controllers.errors import BadSetting
from controllers.kinematics import Arm, Array, Kinematics, largest_bend
from controllers.laws.situation import AUTHORITY
from controllers.limits import VelocityBox
from controllers.proximity import ProximityDetector
from controllers.tasks import TASK_DIMENSION
from scenes.rigs import Rig, for_reach, rig_named
from scenes.robots import Robot, robot
from scenes.robots.start_search import arm_reach, found_postures
from scenes.setting_spec import makes
from scenes.settings import ArmName, ControlPoint, RunSettings

SIDES: tuple[ArmName, ArmName] = ("left", "right")

CLEAR: Final = 0.25
"""Sufficient distance of two arms at the start [m]."""

LEAST_CLEAR: Final = 0.18
"""Smallest distance of two arms at the start that fits the rig [m]."""


@dataclass(frozen=True)
class Room:
    """Constant parts of a place, shared by all users: never write to it.

    Attributes:
        model: all arms, left first (14 joints for two LWRs), then the ball's three translations or the wall.
        geometry: capsules, named "left hand" …, and their pairs.
        arms: left and right, or a single one.
        start: q (nv,) [rad, m].
        ball, wall: columns in q, or None.
        point: part that keeps clear of the ball.
        watch: makes the detector of other first tasks; None for the distances of the bodies.
    """

    rig: Rig
    robots: tuple[Robot, ...]
    model: pin.Model
    geometry: pin.GeometryModel
    arms: tuple[Arm, ...]
    start: Array
    ball: slice | None = None
    point: ControlPoint = "arm"
    wall: slice | None = None
    watch: "Callable[[World], ProximityDetector] | None" = None

    @property
    def meets_bodies(self) -> bool:
        """True if the laws act on distances of bodies."""
        return self.watch is None

    @property
    def columns(self) -> tuple[str, ...]:
        """Name of every column of q, with {} for "q", "dq" or "qd": "left_{}1" …"""
        arms = (
            f"{arm.name}_{{}}{i + 1}" for arm in self.arms for i in range(arm.joints.stop - arm.joints.start)
        )
        ball = (f"ball_{{}}_{axis}" for axis in "xyz") if self.ball is not None else ()
        wall = (f"wall_{{}}_{axis}" for axis in (*"xyz", "turn", "tilt")) if self.wall is not None else ()
        return (*arms, *ball, *wall)

    def arm(self, side: ArmName) -> Arm:
        """Arm of a side, or the only arm."""
        return self.arms[min(SIDES.index(side), len(self.arms) - 1)]

    def other(self, side: ArmName) -> Arm:
        """Arm opposite a side, or the only arm."""
        return self.arms[min(1 - SIDES.index(side), len(self.arms) - 1)]

    def bend(self, arm: Arm) -> float:
        """a of an arm for `quiet_solution` [m/rad²]."""
        made = self.robots[self.arms.index(arm)]
        return largest_bend(arm_reach(made), made.model.nv)

    def task(self, settings: RunSettings) -> HandTask:
        """Task of a hand: only its position if an arm has fewer than six joints."""
        return settings.task if self._hands_turn else "position"

    @cached_property
    def _hands_turn(self) -> bool:
        return all(arm.joints.stop - arm.joints.start >= TASK_DIMENSION["pose"] for arm in self.arms)


class World:
    """Everything that moves, and what is computed from it.

    Args:
        limit_gain: gain near a joint's stop [1/s].
    """

    def __init__(self, room: Room, limit_gain: float) -> None:
        self.room = room
        self.kinematics = Kinematics(room.model, room.arms)
        self.positions: Array = room.start.copy()
        self.velocities: Array = np.zeros(room.model.nv)
        self.detector = (
            ProximityDetector(self.kinematics, room.geometry) if room.watch is None else room.watch(self)
        )
        model = room.model
        self.bounds = VelocityBox(
            model.lowerPositionLimit.copy(),
            model.upperPositionLimit.copy(),
            model.velocityLimit.copy(),
            limit_gain,
        )

    def update(self) -> None:
        self.kinematics.update(self.positions)
        self.bounds.update(self.positions)


def random_bounds(room: Room) -> tuple[Array, Array]:
    """Bounds of a random start (nv,) [rad, m]; ball and wall stay near their places."""
    low, high = room.model.lowerPositionLimit.copy(), room.model.upperPositionLimit.copy()
    if room.ball is not None:
        low[room.ball], high[room.ball] = room.start[room.ball] - 0.8, room.start[room.ball] + 0.8
    if room.wall is not None:
        around = np.array([0.3, 0.3, 0.3, 0.6, 0.6])
        low[room.wall], high[room.wall] = room.start[room.wall] - around, room.start[room.wall] + around
    return low, high


@cache
def build_room(rig_name: str, robot_name: str = "lwr") -> Room:
    """Room of a rig with two arms, cached."""
    made = tuple(map(robot, makes(robot_name)))
    rig = for_reach(rig_named(rig_name), sum(map(arm_reach, made)) / len(made))
    model, geometry = pin.Model(), pin.GeometryModel()
    arms: list[Arm] = []
    for side, base, one in zip(SIDES, rig.bases, made, strict=True):
        model, arm = with_arm(model, geometry, one, side, base)
        arms.append(arm)
    pair_bodies(model, geometry, "left ", "right ")
    room = Room(rig, made, model, geometry, tuple(arms), np.zeros(model.nq))
    return replace(room, start=_start_of_two(room))


def _start_of_two(room: Room) -> Array:
    """Known start q (nv,) [rad] of both arms, or the best found; BadSetting if none is clear."""
    left, right = (
        found_postures(made, base, other, side, room.rig.name)
        for made, base, other, side in zip(
            room.robots, room.rig.bases, room.rig.bases[::-1], SIDES, strict=True
        )
    )
    both = [np.concatenate([a, b]) for a in left for b in right]
    if len(both) == 1:
        return both[0]
    kinematics = Kinematics(room.model, room.arms)
    detector = ProximityDetector(kinematics, room.geometry)

    def clearance(q: Array) -> float:
        kinematics.update(q)
        return detector.detect("single").distance

    # Both lists begin with the best: take the first pair with enough clearance, else the largest.
    ranked = [(min(clearance(q), CLEAR), -i) for i, q in enumerate(both)]
    distance, place = max(ranked)
    if distance < LEAST_CLEAR:
        raise BadSetting(
            "{left} and {right} find no start on the rig {rig} that keeps them {least:g} m apart (at best {best:.2f} m); "
            "choose another rig, or place them farther apart with --base-left and --base-right.",
            left=room.robots[0].name,
            right=room.robots[1].name,
            rig=room.rig.name,
            least=LEAST_CLEAR,
            best=distance,
        )
    return both[-place]


def with_arm(
    model: pin.Model, geometry: pin.GeometryModel, made: Robot, name: str, base: pin.SE3
) -> tuple[pin.Model, Arm]:
    """The model with one more arm, and the arm; adds its capsules to `geometry`."""
    first, offset = model.nv, model.njoints - 1
    model = pin.appendModel(model, _renamed(made.model, name), 0, base)
    for capsule in made.capsules:
        axis = capsule.end - capsule.start
        length = float(np.linalg.norm(axis))
        turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), axis / length).toRotationMatrix()
        placement = pin.SE3(turn, (capsule.start + capsule.end) / 2.0)
        joint = capsule.joint + offset if capsule.joint else 0
        shape = coal.Capsule(capsule.radius, length)
        geometry.addGeometryObject(
            pin.GeometryObject(
                f"{name} {capsule.name}", joint, placement if joint else base * placement, shape
            )
        )
    return model, Arm(
        name,
        slice(first, first + made.model.nv),
        model.getFrameId(f"{name}_{made.hand}"),
        made.shoulder + offset,
        made.elbow + offset,
        made.wrist + offset,
        made.labels,
    )


def _renamed(model: pin.Model, side: str) -> pin.Model:
    model = model.copy()
    for i in range(1, model.njoints):
        model.names[i] = f"{side}_{model.names[i]}"
    for i in range(1, model.nframes):
        model.frames[i].name = f"{side}_{model.frames[i].name}"
    return model


def pair_bodies(
    model: pin.Model, geometry: pin.GeometryModel, first: str, second: str, movable: bool = False
) -> None:
    """Pair the bodies of two name prefixes, except those at a constant distance, J_d ≡ 0.

    Two fixed bodies are not paired; at a fixed body a link begins where it moves. `movable` leaves out the
    fixed bodies of the first prefix.
    """
    left = [i for i, body in enumerate(geometry.geometryObjects) if body.name.startswith(first)]
    right = [i for i, body in enumerate(geometry.geometryObjects) if body.name.startswith(second)]
    for a in left:
        for b in right:
            fixed_a, fixed_b = (geometry.geometryObjects[i].parentJoint == 0 for i in (a, b))
            if fixed_a and (fixed_b or movable):
                continue
            pair = (
                (a, _moving_part(model, geometry, b))
                if fixed_a
                else (_moving_part(model, geometry, a), b)
                if fixed_b
                else (a, b)
            )
            if None not in pair:
                geometry.addCollisionPair(pin.CollisionPair(*pair))


def _moving_part(model: pin.Model, geometry: pin.GeometryModel, body: int) -> int | None:
    """Body of the part of a capsule that moves by at least `AUTHORITY`, added unless it is the whole capsule;
    None without such a part.
    """
    capsule = geometry.geometryObjects[body]
    data, random = model.createData(), np.random.default_rng(1)
    half = float(capsule.geometry.halfLength)
    along = np.linspace(-half, half, 201)
    points = np.outer(along, capsule.placement.rotation[:, 2]) + capsule.placement.translation
    levers = np.full(len(along), np.inf)
    for q in random.uniform(model.lowerPositionLimit, model.upperPositionLimit, (8, model.nq)):
        J = pin.computeJointJacobian(model, data, q, capsule.parentJoint)
        moved = J[:3].T + np.cross(J[3:].T, points[:, np.newaxis])
        levers = np.minimum(levers, np.linalg.norm(moved, 2, axis=(1, 2)))
    moving = np.flatnonzero(levers >= AUTHORITY)
    if len(moving) == len(along):
        return body
    if len(moving) == 0:
        return None
    low, high = along[moving[0]], along[moving[-1]]
    place = capsule.placement * pin.SE3(np.eye(3), np.array([0.0, 0.0, (low + high) / 2.0]))
    shape = coal.Capsule(capsule.geometry.radius, float(high - low))
    side, link = capsule.name.split(" ", 1)
    return geometry.addGeometryObject(
        pin.GeometryObject(f"{side} outer {link}", capsule.parentJoint, place, shape)
    )
