"""Self-collision pairs of an arm."""

import pinocchio as pin

from controllers.kinematics import Arm, Kinematics
from scenes.room import Room


def own_pairs(room: Room, arm: Arm, least: float) -> pin.GeometryModel:
    """Pairs of an arm's capsules, except neighbours.

    Args:
        least: pairs nearer than this in the room's start posture are left out [m]; they overlap by shape.
    """
    made = room.robots[room.arms.index(arm)]
    geometry = pin.GeometryModel()
    for capsule in made.capsules:
        body = room.geometry.getGeometryId(f"{arm.name} {capsule.name}")
        geometry.addGeometryObject(room.geometry.geometryObjects[body])
    count = len(made.capsules)
    every = [(i, k) for i in range(count) for k in range(i + 2, count)]
    for pair in every:
        geometry.addCollisionPair(pin.CollisionPair(*pair))
    kinematics, data = Kinematics(room.model, room.arms), geometry.createData()
    kinematics.update(room.start)
    pin.updateGeometryPlacements(room.model, kinematics.data, geometry, data)
    if every:
        pin.computeDistances(geometry, data)
    for i, pair in enumerate(every):
        if data.distanceResults[i].min_distance < least:
            geometry.removeCollisionPair(pin.CollisionPair(*pair))
    return geometry
