"""Table, stand, floor and an arm's own links as one first task."""

from dataclasses import dataclass
from typing import Final

import coal
import numpy as np
import pinocchio as pin

from controllers.first_tasks.links_over_boxes import LinkCapsule, LinksOverBoxes
from controllers.first_tasks.surroundings import Meeting, Surroundings
from controllers.kinematics import Arm, Array, Kinematics
from scenes.furniture import Column, furniture_of
from scenes.own_pairs import own_pairs
from scenes.room import Room, World

MARGIN: Final = 0.03
"""h_m: distance at which an arm glides along things [m]."""

RETREAT: Final = 0.05
"""v: speed of retreat from a touched thing [m/s]."""

TOUCHING: Final = 2.0 * MARGIN
"""Things nearer at the start belong together and are left out, as a pedestal and its table [m]."""


def surroundings(
    world: World, arm: Arm, critical_value: float = MARGIN, nominal_rate: float = RETREAT
) -> Surroundings | None:
    """Distance of an arm from furniture, floor and its own links; None if it can meet nothing.

    Args:
        critical_value: h_m [m].
        nominal_rate: v [m/s].
    """
    room, furniture = world.room, furniture_of(world.room.rig)
    geometry = own_pairs(room, arm, TOUCHING)
    _add_columns(room, geometry, furniture.columns)
    bodies = [_capsule(body) for body in geometry.geometryObjects]
    names = [body.name.removeprefix(f"{arm.name} ") for body in geometry.geometryObjects]
    meetings = [Meeting(pair.first, pair.second) for pair in geometry.collisionPairs]
    for number, body in enumerate(bodies):
        if body.joint and _starts_clear(room, arm, body, furniture.boxes):
            meetings += [Meeting(number, box, over_box=True) for box in range(len(furniture.boxes))]
    if not meetings:
        return None
    joints = [arm.joint(number) for number in range(1, arm.joints.stop - arm.joints.start + 1)]
    things = names, bodies, meetings, furniture.boxes
    return Surroundings(world.kinematics, arm, joints, *things, critical_value, nominal_rate)


@dataclass(frozen=True)
class _Ball:
    """Columns of the ball in q."""

    joints: slice


def ball_surroundings(world: World) -> Surroundings | None:
    """Distance of the ball to pedestals, stand and furniture; None without a ball or if it starts at one."""
    room, ball_columns = world.room, world.room.ball
    if ball_columns is None:
        return None
    ball = room.geometry.geometryObjects[room.geometry.getGeometryId("ball")]
    fixed = [body for body in room.geometry.geometryObjects if body.parentJoint == 0]
    furniture = furniture_of(room.rig)
    columns = [
        LinkCapsule(0, (one.start + one.end) / 2.0, (one.end - one.start) / 2.0, one.radius)
        for one in furniture.columns
    ]
    bodies = [
        LinkCapsule(ball.parentJoint, np.zeros(3), np.zeros(3), ball.geometry.radius),
        *map(_capsule, fixed),
        *columns,
    ]
    names = ["ball", *("pedestal" for _ in fixed), *(f"stand {i}" for i in range(len(columns)))]
    meetings = [Meeting(0, i) for i in range(1, len(bodies))]
    meetings += [Meeting(0, box, over_box=True) for box in range(len(furniture.boxes))]

    def at(kinematics: Kinematics) -> Surroundings:
        things = names, bodies, meetings, furniture.boxes
        return Surroundings(kinematics, _Ball(ball_columns), [ball.parentJoint], *things, MARGIN, RETREAT)

    return at(world.kinematics) if at(_start_of(room)).margin().value >= TOUCHING else None


def _start_of(room: Room) -> Kinematics:
    kinematics = Kinematics(room.model, room.arms)
    kinematics.update(room.start)
    return kinematics


def _add_columns(room: Room, geometry: pin.GeometryModel, columns: tuple[Column, ...]) -> None:
    """Pair moving capsules with columns that they do not touch in the start posture."""
    links = [i for i, body in enumerate(geometry.geometryObjects) if body.parentJoint]
    added: list[tuple[int, int]] = []
    for number, column in enumerate(columns):
        way = column.end - column.start
        length = float(np.linalg.norm(way))
        turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), way / length).toRotationMatrix()
        place = pin.SE3(turn, (column.start + column.end) / 2.0)
        shape = coal.Capsule(column.radius, length)
        fixed = geometry.addGeometryObject(pin.GeometryObject(f"stand {number}", 0, place, shape))
        added += [(link, fixed) for link in links]
    before = len(geometry.collisionPairs)
    for pair in added:
        geometry.addCollisionPair(pin.CollisionPair(*pair))
    data = geometry.createData()
    pin.updateGeometryPlacements(room.model, _start_of(room).data, geometry, data)
    if added:
        pin.computeDistances(geometry, data)
    for i, pair in enumerate(added):
        if data.distanceResults[before + i].min_distance < TOUCHING:
            geometry.removeCollisionPair(pin.CollisionPair(*pair))


def _capsule(body: pin.GeometryObject) -> LinkCapsule:
    half = body.placement.rotation[:, 2] * body.geometry.halfLength
    return LinkCapsule(body.parentJoint, body.placement.translation.copy(), half, body.geometry.radius)


def _starts_clear(room: Room, arm: Arm, link: LinkCapsule, boxes: Array) -> bool:
    return LinksOverBoxes(_start_of(room), arm, (link,), boxes).margin().value >= TOUCHING
