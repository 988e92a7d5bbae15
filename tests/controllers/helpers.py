"""Random postures of the real arms, and derivatives by finite differences."""

from collections.abc import Callable

import numpy as np

from controllers.kinematics import Array, Kinematics
from controllers.proximity import ProximityDetector
from scenes.room import Room, build_room
from scenes.settings import RigName


def bodies(rig: RigName) -> tuple[Room, Kinematics, ProximityDetector]:
    """A rig's room with new kinematics and a new detector."""
    room = build_room(rig)
    kinematics = Kinematics(room.model, room.arms)
    return room, kinematics, ProximityDetector(kinematics, room.geometry)


def random_postures(room: Room, count: int, seed: int) -> Array:
    model = room.model
    return np.random.default_rng(seed).uniform(
        model.lowerPositionLimit, model.upperPositionLimit, (count, model.nv)
    )


def derivative(function: Callable[[Array], Array], at: Array, step: float = 1e-6) -> Array:
    """∂f/∂q by central differences (shape of f, nv)."""
    columns = []
    for i in range(len(at)):
        forth, back = at.copy(), at.copy()
        forth[i] += step
        back[i] -= step
        columns.append((np.asarray(function(forth)) - np.asarray(function(back))) / (2.0 * step))
    return np.stack(columns, axis=-1)


def overlapping_postures(rig: RigName, depth: float, count: int, seed: int) -> list[Array]:
    room, kinematics, detector = bodies(rig)
    found: list[Array] = []
    for q in random_postures(room, 20_000, seed):
        kinematics.update(q)
        if detector.detect().distance < -depth:
            found.append(q)
            if len(found) == count:
                break
    assert len(found) == count
    return found
