"""What an arm can meet apart from the other arm: table, stand, floor and itself, as one first task."""

from typing import Final

import coal
import numpy as np
import pinocchio as pin

from controllers.first_tasks.first_task import FirstTask
from controllers.first_tasks.links_over_boxes import LinkCapsule, LinksOverBoxes
from controllers.first_tasks.own_links import OwnLinks
from controllers.first_tasks.several_at_once import SeveralAtOnce
from controllers.kinematics import Arm, Kinematics
from controllers.row_stage import RowStage, smooth_stage
from scenes.furniture import Column, Furniture, furniture_of
from scenes.own_pairs import own_pairs
from scenes.room import Room, World

MARGIN: Final = 0.03
"""h_m: an arm glides along things at about this distance [m]."""

RETREAT: Final = 0.05
"""v: how fast it leaves what it touches [m/s]."""

ORDER: Final = 6.0
"""n."""

TOUCHING: Final = 2.0 * MARGIN
"""What is nearer than this in the start posture is left out [m]: such things belong together, as a pedestal and its table."""


def surroundings(world: World, arm: Arm, critical_value: float = MARGIN, nominal_rate: float = RETREAT) -> FirstTask | None:
    """Return the distance of an arm from furniture, floor and its own links; None if it can meet nothing.

    Args:
        world: with the arm.
        arm: which one.
        critical_value: h_m [m].
        nominal_rate: v [m/s].
    """
    room, furniture = world.room, furniture_of(world.room.rig)
    found: list[FirstTask] = []
    geometry = own_pairs(room, arm, TOUCHING)
    _add_columns(room, geometry, furniture.columns)
    if len(geometry.collisionPairs):
        found.append(OwnLinks(world.kinematics, arm, geometry, critical_value, nominal_rate))
    links = _links(room, arm, furniture)
    if links:
        found.append(LinksOverBoxes(world.kinematics, arm, links, furniture.boxes, critical_value, nominal_rate))
    # One threshold for all of them: their plain smooth minimum, with the β of each.
    return SeveralAtOnce(found, "distance from table, stand and itself", 100.0 * critical_value) if found else None


def world_stage(world: World, arm: Arm) -> RowStage | None:
    """Return the stage that keeps an arm clear of its surroundings by the paper's law; None if it can meet nothing."""
    task = surroundings(world, arm)
    return None if task is None else smooth_stage(task, world.bounds.part(arm.joints), ORDER, one_sided=True)


def _start_of(room: Room) -> Kinematics:
    kinematics = Kinematics(room.model, room.arms)
    kinematics.update(room.start)
    return kinematics


def _add_columns(room: Room, geometry: pin.GeometryModel, columns: tuple[Column, ...]) -> None:
    """Pair every moving capsule of a geometry with every column that it does not touch in the start posture."""
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


def _links(room: Room, arm: Arm, furniture: Furniture) -> list[LinkCapsule]:
    """Return the moving capsules of an arm that touch no box in the start posture."""
    kinematics, found = _start_of(room), list[LinkCapsule]()
    for capsule in room.robots[room.arms.index(arm)].capsules:
        body = room.geometry.geometryObjects[room.geometry.getGeometryId(f"{arm.name} {capsule.name}")]
        if body.parentJoint == 0:
            continue
        half = body.placement.rotation[:, 2] * body.geometry.halfLength
        link = LinkCapsule(body.parentJoint, body.placement.translation.copy(), half, capsule.radius)
        if LinksOverBoxes(kinematics, arm, (link,), furniture.boxes).margin().value >= TOUCHING:
            found.append(link)
    return found
