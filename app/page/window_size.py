"""A visitor's window, as the page's own request says it."""

import re
from typing import Final

import viser

from app.web.request import request_query

TITLEBAR: Final = 47.0
"""Height of the bar at the top [CSS px]."""


def canvas_size(client: viser.ClientHandle) -> tuple[float, float]:
    """Return width and height of a client's window below the title bar, as they were when it came [CSS px].

    The camera's own size is in device pixels, and of a canvas that has not found its place yet.
    """
    given = re.fullmatch(r"(\d{2,5})x(\d{2,5})", request_query(client).get("window", ""))
    if given is None:
        return max(client.camera.image_width, 1.0), max(client.camera.image_height, 1.0)
    return float(given[1]), max(float(given[2]) - TITLEBAR, 1.0)
