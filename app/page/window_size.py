"""A visitor's window, as the page's own request says it."""

import re
from functools import lru_cache
from typing import Final

import viser

from app.web.index_page import page_query
from app.web.viser_internals import request_of

TITLEBAR: Final = 47.0
"""Height of the bar at the top [CSS px]."""


def canvas_size(client: viser.ClientHandle) -> tuple[float, float]:
    """Return width and height of a client's window below the title bar, as they were when it came [CSS px].

    The camera's own size is in device pixels, and of a canvas that has not found its place yet.
    """
    request = request_of(client)
    given = None if request is None else _given(request.path)
    return given or (max(client.camera.image_width, 1.0), max(client.camera.image_height, 1.0))


@lru_cache(maxsize=256)
def _given(path: str) -> tuple[float, float] | None:
    given = re.fullmatch(r"(\d{2,5})x(\d{2,5})", page_query(path).get("window", ""))
    return None if given is None else (float(given[1]), max(float(given[2]) - TITLEBAR, 1.0))
