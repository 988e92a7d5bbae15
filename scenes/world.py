"""The arms and obstacles of a room as they stand now."""

import numpy as np

from controllers.kinematics import Array, Kinematics
from controllers.limits import VelocityBox
from controllers.proximity import ProximityDetector
from scenes.room import Room


class World:
    """Positions and velocities of everything that moves, and all that is computed from them.

    Args:
        limit_gain: how softly a joint comes to rest at its stop [1/s].
    """

    def __init__(self, room: Room, limit_gain: float) -> None:
        self.room = room
        self.kinematics = Kinematics(room.model, room.arms)
        self.detector = ProximityDetector(self.kinematics, room.geometry)
        self.positions: Array = room.start.copy()
        self.velocities: Array = np.zeros(room.model.nv)
        model = room.model
        self.bounds = VelocityBox(
            model.lowerPositionLimit.copy(), model.upperPositionLimit.copy(), model.velocityLimit.copy(), limit_gain
        )

    def update(self) -> None:
        """Compute poses, Jacobians and velocity bounds at the present positions."""
        self.kinematics.update(self.positions)
        self.bounds.update(self.positions)
