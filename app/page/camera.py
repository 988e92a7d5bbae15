"""Where a visitor's camera stands: the scene's view, fitted into the part of the canvas that no panel covers."""

import numpy as np
import viser

from scenes.rigs import Camera


def place_camera(client: viser.ClientHandle, camera: Camera, covered: float) -> None:
    """Move a client's camera so that everything the view must show is in the free part of its canvas.

    Args:
        covered: share of the canvas' height, at its bottom, that a panel covers.
    """
    slope = float(np.tan(camera.fov / 2.0))
    distance = max(camera.height / (1.0 - covered), camera.width / max(client.camera.aspect, 0.2)) / (2.0 * slope)
    toward = np.array(camera.toward) / np.linalg.norm(camera.toward)
    right = np.cross([0.0, 0.0, 1.0], toward)
    up = np.cross(toward, right / np.linalg.norm(right))
    # Looking below the middle lifts it out of the part that is covered.
    target = np.array(camera.centre) - up * (distance * slope * covered)
    client.camera.up_direction = (0.0, 0.0, 1.0)
    client.camera.position = target + toward * distance
    client.camera.look_at = target
    client.camera.fov = camera.fov
