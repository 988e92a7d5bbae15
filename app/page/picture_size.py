"""Free part of the 3-D view."""

import re
from collections.abc import Callable
from functools import lru_cache
from typing import Final, NamedTuple

import viser

from app.settings import Profile
from app.text.templates import element
from app.theme import PLOTS_FRAME, plots_height, scale
from app.web.control_events import on_entry
from app.web.pages import page_query
from app.web.viser_internals import request_of, uuid_of

TITLEBAR: Final = 47.0
"""Height of the title bar before the first report [CSS px]."""

PHONE: Final = 576.0
"""Largest window width with viser's single sheet at the bottom [CSS px]."""


class PictureSize(NamedTuple):
    """Report of a browser [CSS px].

    Attributes:
        window: width of the window.
        width, height: of the 3-D view.
        covered: height of the plots, open or folded.
        card_right, card_bottom: far corner of the card; 0 without one.
    """

    window: float
    width: float
    height: float
    covered: float
    card_right: float
    card_bottom: float


class PictureReport:
    """Receives the size from `picture_size.js`.

    Args:
        tab: holds a second mark, because a folded panel removes its own.
        page: returns profile and `bare`, see `free_picture`.
    """

    def __init__(
        self, client: viser.ClientHandle, tab: viser.GuiTabHandle, page: Callable[[], tuple[Profile, bool]]
    ) -> None:
        self._client, self._page = client, page
        self._size: PictureSize | None = None
        self._taken: object = client.camera.aspect
        box = on_entry(client.gui.add_text("", "", visible=False), self._take)
        mark = element("i", hidden="", data_duet_picture=uuid_of(box))
        client.gui.add_html(mark, order=-1.0)
        with tab:
            client.gui.add_html(mark, order=-1.0)

    def _take(self, text: str) -> None:
        found = re.fullmatch(
            r"([1-9]\d{0,4}) ([1-9]\d{0,4}) ([1-9]\d{0,4}) (\d{1,5}) (\d{1,5}) (\d{1,5})", text
        )
        if found is not None:
            self._size = PictureSize(*map(float, found.groups()))

    def take_change(self) -> bool:
        """True if the size changed or the card appeared since the last call; a card that only grows does
        not count."""
        before, size = self._taken, self._size
        self._taken = self._client.camera.aspect if size is None else (*size[:4], size.card_bottom > 0.0)
        return before != self._taken

    def free(self) -> "FreePicture":
        """Free part; of the usual layout until the first report."""
        (profile, bare), size = self._page(), self._size
        if size is not None:
            return free_picture((size.window, size.height), size.width, profile, bare, size.covered, size[4:])
        window = canvas_size(self._client)
        width = max(self._client.camera.aspect, 0.2) * window[1]
        return free_picture(window, width, profile, bare)


def canvas_size(client: viser.ClientHandle) -> tuple[float, float]:
    """Width and height of a client's window below the title bar when it connected [CSS px]; its camera
    counts device pixels."""
    request = request_of(client)
    given = None if request is None else _window_of(request.path)
    return given or (max(client.camera.image_width, 1.0), max(client.camera.image_height, 1.0))


@lru_cache(maxsize=256)
def _window_of(path: str) -> tuple[float, float] | None:
    """Size in a page's address, without the title bar [CSS px], or None."""
    given = re.fullmatch(r"(\d{2,5})x(\d{2,5})", page_query(path).get("window", ""))
    return None if given is None else (float(given[1]), max(float(given[2]) - TITLEBAR, 1.0))


CARD: Final = (330.0, 190.0)
"""Width and height [CSS px], times the profile's scale."""

PHONE_CARD: Final = 120.0
"""Height of the card on a phone [CSS px]."""

CARD_MARGIN: Final = 14.0

LOW_CANVAS: Final = 520.0
"""Height below which the plots begin folded [CSS px]."""

PLOTS_ROW: Final = (720.0, 32.0)
"""Width below which the choice of plots needs a second row, and its height [CSS px]."""

PLOTS_BAR: Final = 60.0
"""Height of the folded plots [CSS px]."""

CAPTION: Final = 0.13
"""Share of a projector's height below the scene."""

PHONE_ASPECT: Final = 0.62
"""Width over height below which a window is a phone's."""

PHONE_SHEET: Final = 0.48
"""Share of a phone's height for the panels."""

LEAST: Final = 80.0
"""Least width or height of a free part [CSS px]."""


class Rectangle(NamedTuple):
    """A part of the picture [CSS px], from its top left corner."""

    left: float
    top: float
    right: float
    bottom: float

    def inset(self, share: float) -> "Rectangle":
        """Rectangle without a margin of `share` of its shorter side."""
        margin = share * min(self.right - self.left, self.bottom - self.top)
        return Rectangle(self.left + margin, self.top + margin, self.right - margin, self.bottom - margin)

    def contains(self, x: float, y: float) -> bool:
        return self.left <= x <= self.right and self.top <= y <= self.bottom


class FreePicture(NamedTuple):
    """A picture between the docked panels.

    Attributes:
        width, height: of the picture [CSS px].
        open: above the plots, or above a phone's sheet.
        free: parts beside and below the card; together all free space.
    """

    width: float
    height: float
    open: Rectangle
    free: tuple[Rectangle, ...]

    def contains(self, x: float, y: float, share: float = 0.0) -> bool:
        """`share`: of the margin, see `Rectangle.inset`."""
        return any(part.inset(share).contains(x, y) for part in self.free)


@lru_cache(maxsize=256)
def free_picture(
    window: tuple[float, float],
    width: float,
    profile: Profile,
    bare: bool = False,
    plots_cover: float | None = None,
    card: tuple[float, float] | None = None,
) -> FreePicture:
    """Free part of a picture; all lengths are in CSS px.

    Args:
        window: width and height below the title bar.
        width: of the picture, without docked panels.
        bare: True with a line below the scene instead of panels.
        plots_cover: height of the plots or of a phone's sheet; None for the usual layout.
        card: right and lower end of the card; None for the usual layout.
    """
    height, k = window[1], scale(profile)
    phone = window[0] / height < PHONE_ASPECT
    if bare:
        covered = CAPTION * height
    elif phone:
        covered = min(plots_cover or PHONE_SHEET * height, 0.75 * height)
    elif plots_cover is not None:
        covered = min(plots_cover, 0.6 * height)
    else:
        row = PLOTS_ROW[1] * k if width < PLOTS_ROW[0] * k else 0.0
        panel = plots_height(height, profile) + PLOTS_FRAME * k + row if height >= LOW_CANVAS else PLOTS_BAR
        covered = min(panel, 0.6 * height)
    whole = Rectangle(0.0, 0.0, width, height - covered)
    if card is None:
        card = (
            (width, PHONE_CARD - CARD_MARGIN)
            if phone
            else (CARD[0] * k + CARD_MARGIN, CARD[1] * k + CARD_MARGIN)
        )
    right, bottom = (end + CARD_MARGIN if end else 0.0 for end in card)
    beside, below = whole._replace(left=right), whole._replace(top=bottom)
    useful = [
        part for part in (beside, below) if min(part.right - part.left, part.bottom - part.top) >= LEAST
    ]
    return FreePicture(width, height, whole, tuple(useful) or (whole,))
