"""Which part of the 3-D picture is free: above the plots or the phone's sheet, and out from under the card of the line of contact."""

from typing import Final, NamedTuple

from app.settings import Profile
from app.theme import PLOTS_FRAME, plots_height, scale

CARD: Final = (330.0, 190.0)
"""Width and height of the card over the picture's top left corner [CSS px], times the profile's scale …"""

PHONE_CARD: Final = 120.0
"""… and its height on a phone, where it is as wide as the picture [CSS px]."""

CARD_MARGIN: Final = 14.0
"""Around the card [CSS px]."""

LOW_CANVAS: Final = 520.0
"""On a canvas lower than this the plots begin folded up [CSS px]."""

PLOTS_ROW: Final = (720.0, 32.0)
"""On a picture narrower than this the choice of plots needs a second row, and how high that is [CSS px]."""

PLOTS_BAR: Final = 60.0
"""Height of the folded plots [CSS px]."""

CAPTION: Final = 0.13
"""Share of a projector's height that the line below a scene without panels covers."""

PHONE_ASPECT: Final = 0.62
"""Width over height of the window below which it is a phone's."""

PHONE_SHEET: Final = 0.48
"""Share of a phone's height that the panels cover."""

LEAST: Final = 80.0
"""A free part narrower or lower than this is of no use [CSS px]."""


class Rectangle(NamedTuple):
    """A part of the picture [CSS px], from its top left corner."""

    left: float
    top: float
    right: float
    bottom: float

    def inset(self, share: float) -> "Rectangle":
        """Return the rectangle without a margin, a share of its shorter side."""
        margin = share * min(self.right - self.left, self.bottom - self.top)
        return Rectangle(self.left + margin, self.top + margin, self.right - margin, self.bottom - margin)

    def contains(self, x: float, y: float) -> bool:
        return self.left <= x <= self.right and self.top <= y <= self.bottom


class FreePicture(NamedTuple):
    """A picture between the docked panels, and what of it is free.

    Attributes:
        width, height: of the picture [CSS px].
        open: above the plots, or above the sheet of a phone.
        free: parts of it beside and below the card; together they are all that is free.
    """

    width: float
    height: float
    open: Rectangle
    free: tuple[Rectangle, ...]

    def contains(self, x: float, y: float, share: float = 0.0) -> bool:
        """Return whether a point is free. `share`: of the margin, see `Rectangle.inset`."""
        return any(part.inset(share).contains(x, y) for part in self.free)


def free_picture(
    window: tuple[float, float], width: float, profile: Profile, bare: bool = False, plots_cover: float | None = None
) -> FreePicture:
    """Return what is free of a picture.

    Args:
        window: width and height of the window below the title bar [CSS px].
        width: of the picture, which is what docked panels leave of the window's [CSS px].
        profile: of the page.
        bare: whether the page shows no panels, but a line below the scene.
        plots_cover: how high the plots are over the picture; None where only the page's usual layout is known [CSS px].
    """
    height, k = window[1], scale(profile)
    phone = window[0] / height < PHONE_ASPECT
    if bare:
        covered = CAPTION * height
    elif phone:
        covered = PHONE_SHEET * height
    elif plots_cover is not None:
        covered = min(plots_cover, 0.6 * height)
    else:
        row = PLOTS_ROW[1] * k if width < PLOTS_ROW[0] * k else 0.0
        panel = plots_height(height, profile) + PLOTS_FRAME * k + row if height >= LOW_CANVAS else PLOTS_BAR
        covered = min(panel, 0.6 * height)
    whole = Rectangle(0.0, 0.0, width, height - covered)
    beside = whole._replace(left=width if phone else CARD[0] * k + 2.0 * CARD_MARGIN)
    below = whole._replace(top=PHONE_CARD if phone else CARD[1] * k + 2.0 * CARD_MARGIN)
    useful = [part for part in (beside, below) if min(part.right - part.left, part.bottom - part.top) >= LEAST]
    return FreePicture(width, height, whole, tuple(useful) or (whole,))
