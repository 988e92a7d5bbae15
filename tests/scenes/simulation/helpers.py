"""What several tests of the loop need."""

import numpy as np

from controllers.choices import Treatment
from scenes.simulation import Simulation

SEEDS = (1, 2, 3)
TREATMENTS: tuple[Treatment, ...] = ("single", "soft")


def inside_limits(simulation: Simulation) -> bool:
    model, q, dq = simulation.room.model, simulation.positions, simulation.velocities
    inside = (q >= model.lowerPositionLimit - 1e-12).all() and (q <= model.upperPositionLimit + 1e-12).all()
    return bool(np.isfinite(q).all() and inside and (np.abs(dq) <= model.velocityLimit + 1e-12).all())
