"""Rooms of the first tasks: one LWR on a bench or a cart, perhaps with a wall."""

from functools import cache
from typing import Final

import numpy as np
import pinocchio as pin

from controllers.errors import BadSetting
from controllers.first_tasks.centre_of_mass import CentreOfMass, Foot
from controllers.first_tasks.first_task import FirstTask
from controllers.first_tasks.joint_stops import JointStops
from controllers.first_tasks.points_over_plane import PointsOverPlane, landmarks
from controllers.first_tasks.smallest_singular_value import SmallestSingularValue
from controllers.kinematics import Arm, Array
from controllers.laws.situation import AUTHORITY
from scenes.first_task.detector import FirstTaskDetector
from scenes.first_task.wall import BASE_CLEAR, add_wall, normal_of, plane_of
from scenes.furniture import CART_HALF
from scenes.quantities import PARTS, SINGULAR, STOPS, TIP, WALL
from scenes.rigs import ALONE, CART, beside_wall
from scenes.robots import robot
from scenes.room import Room, World, with_arm
from scenes.solo import ALONE_NAME, alone_start

MAKE: Final = "lwr"

WALL_START: Final = (0.30, 0.0, 1.40, 0.0, 0.0)
"""Middle, turn and tilt of the wall at the start (5,) [m, rad]."""

POINT_RADIUS: Final = 0.05
"""Radius of elbow, wrist and hand [m]."""

CART_MASS: Final = 16.0
"""Of the cart with the arm's base [kg]."""

CART_CENTRE: Final = 0.35
"""Height of its centre of mass [m]."""

AGAINST: Final = {WALL: "wall", STOPS: "joint stops", SINGULAR: "singularity", TIP: "edge of the foot"}
"""First task → second name of its pair."""


def foot_of(base: Array) -> Foot:
    """Foot of the cart below a base (3,), world [m]."""
    x, y, _ = base.tolist()
    return Foot(np.array([x, y]), np.array(CART_HALF), CART_MASS, np.array([x, y, CART_CENTRE]))


def made_task(name: str, world: World, posture: Array, load: float) -> FirstTask:
    """First task of an arm. Its own h_m is not used: all have d_m of the settings, in their units.

    Args:
        posture: q (nv,), a live view.
        load: mass in the hand [kg].
    """
    room, kinematics, arm = world.room, world.kinematics, world.room.arms[0]
    if name == WALL:
        assert room.wall is not None
        plane = plane_of(room.start[room.wall])
        return PointsOverPlane(kinematics, arm, landmarks(room.model, arm, POINT_RADIUS), plane, 1.0)
    if name == STOPS:
        j = arm.joints
        return JointStops(posture[j], room.model.lowerPositionLimit[j], room.model.upperPositionLimit[j], 1.0)
    if name == SINGULAR:
        return SmallestSingularValue(kinematics, arm, 1.0)
    balance = CentreOfMass(kinematics, arm, foot_of(room.rig.bases[0].translation), load, 1.0)
    # The cart is light: a stage is damped at the same lever as the law.
    balance.authority = AUTHORITY
    return balance


@cache
def build_first_task_room(first: str, load: float, stages: bool = False) -> Room:
    """Room of a first task, cached.

    Args:
        first: see `scenes.quantities`.
        load: mass in the hand [kg].
        stages: the law acts only on the first of several.
    """
    kept = PARTS.get(first, (first,))
    rig = CART if TIP in kept else ALONE
    made, geometry = robot(MAKE), pin.GeometryModel()
    model, arm = with_arm(pin.Model(), geometry, made, ALONE_NAME, rig.bases[0])
    start, wall = alone_start(MAKE), None
    if WALL in kept:
        wall, rig = add_wall(model), beside_wall(rig)
        start = np.concatenate([start, WALL_START])

    def watch(world: World) -> FirstTaskDetector:
        posture = room.start.copy()
        tasks = tuple(made_task(name, world, posture, load) for name in kept)
        return FirstTaskDetector(world, tasks, tuple(AGAINST[name] for name in kept), posture, wall, stages)

    room = Room(rig, (made,), model, geometry, (arm,), start, wall=wall, watch=watch)
    return room


def wall_through_base(room: Room, arm: Arm, positions: Array) -> bool:
    """True if the wall is too near to the shoulder. `positions`: q (nv,)."""
    if room.wall is None:
        return False
    at = positions[room.wall]
    data = room.model.createData()
    pin.forwardKinematics(room.model, data, positions)
    shoulder = data.oMi[arm.shoulder].translation
    return float(normal_of(*at[3:].tolist()).dot(shoulder - at[:3])) < BASE_CLEAR


def start_problem(world: World, critical_value: float) -> BadSetting | None:
    """Reason why the present posture cannot keep a first task, or None.

    Args:
        critical_value: h_m, in its unit.
    """
    room, detector = world.room, world.detector
    if wall_through_base(room, room.arms[0], world.positions):
        return BadSetting(
            "The wall is nearer than {least:g} m to the shoulder, which cannot move; take it away from the base.",
            least=BASE_CLEAR,
        )
    detector.detect()
    for value, (_, against) in zip(detector.distances().tolist(), detector.pair_names, strict=True):
        if against == AGAINST[TIP] and value <= 0.0:
            return BadSetting("With this load the cart tips over at the start; take a smaller load.")
        if value < critical_value:
            return BadSetting(
                "d_m = {critical:.3f} is more than the {value:.3f} that the start leaves to the {against}; take a smaller d_m.",
                critical=critical_value,
                value=value,
                against=against,
            )
    return None
