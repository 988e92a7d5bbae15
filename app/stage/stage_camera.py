"""What of an experiment is to be seen, and from where."""

from dataclasses import replace
from typing import Final

import numpy as np

from scenes.rigs import Camera
from scenes.robots import FILES, Robot
from scenes.robots.start_search import arm_reach
from scenes.simulation import Simulation

IMITATION: Final = Camera((0.30, -0.24, 1.09), (2.45, -0.45, 0.69), 2.56, 1.34, float(np.radians(32.0)))
"""Shows the robots with their arms up, and the person beside them with arms stretched out."""

OTHERS: Final[dict[tuple[str, str], tuple[float, float, float]]] = {
    ("panda", "torso"): (1.23, 1.60, 1.02),
    ("panda", "table"): (1.34, 1.85, 1.44),
    ("ur5", "torso"): (1.07, 1.90, 0.95),
    ("ur5", "table"): (1.35, 1.85, 1.48),
}
"""Arms for which the rig's own view was not made: height of its middle, what must be seen across and up [m]."""


PANDA_REACH: Final = 1.15
"""From shoulder to hand [m]."""


def view_of(simulation: Simulation) -> Camera:
    """Return the view of an experiment: its rig's, but wider where the arms are longer or a person is shown beside them."""
    room, camera = simulation.room, simulation.room.rig.camera
    if simulation.settings.scene == "imitation":
        return IMITATION
    if len(room.arms) == 2:
        x, y, own = camera.centre
        views = [_seen(made, room.rig.name) or (own, camera.width, camera.height) for made in room.robots]
        # Everything that either view shows; of two of one make that is its own.
        if views[0] == views[1]:
            z, width, height = views[0]
        else:
            low, high = min(z - h / 2.0 for z, _, h in views), max(z + h / 2.0 for z, _, h in views)
            z, width, height = (low + high) / 2.0, max(w for _, w, _ in views), high - low
        return replace(camera, centre=(x, y, z), width=width, height=height)
    return camera


def _seen(made: Robot, rig: str) -> tuple[float, float, float] | None:
    """Return height of the middle, width and height of the view for a make; None where the rig's own was made for it."""
    if made.key not in FILES:
        return OTHERS.get((made.key, rig))
    if ("panda", rig) not in OTHERS:
        return None
    z, width, height = OTHERS["panda", rig]
    scale = max(arm_reach(made) / PANDA_REACH, 0.85)
    return z, width * scale, height * scale
