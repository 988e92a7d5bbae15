"""A visitor's window: as the page's own request says it, and as the page's script says it from then on."""

import re
from functools import lru_cache
from typing import Any, Final, NamedTuple

import viser

from app.text.html_element import element
from app.web.index_page import page_query
from app.web.viser_internals import request_of, uuid_of

TITLEBAR: Final = 47.0
"""Height of the bar at the top, until the page says how high its picture is [CSS px]."""


class PictureSize(NamedTuple):
    """What a browser says [CSS px].

    Attributes:
        window: width of the window.
        width, height: of the 3-D picture.
        covered: how high the plots cover the picture, open or folded.
    """

    window: float
    width: float
    height: float
    covered: float


class PictureReport:
    """Listens to `picture_size.js` on the page of one client, which sends four numbers by a hidden box when they change.

    Attributes:
        size: None until the page has said it.
    """

    def __init__(self, client: viser.ClientHandle) -> None:
        self.size: PictureSize | None = None
        self._taken: PictureSize | None = None
        box = client.gui.add_text("", "", visible=False)
        client.gui.add_html(element("i", hidden="", data_duet_picture=uuid_of(box)), order=-1.0)

        @box.on_update
        async def _(event: viser.GuiEvent[Any]) -> None:
            found = re.fullmatch(r"([1-9]\d{0,4}) ([1-9]\d{0,4}) ([1-9]\d{0,4}) (\d{1,5})", event.target.value)
            if event.client_id is not None and found is not None:
                self.size = PictureSize(*map(float, found.groups()))

    def take_change(self) -> bool:
        """Return whether the page has said another size since the last call."""
        before, self._taken = self._taken, self.size
        return before != self._taken


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
