"""The title bar: our name and mark, drawn by us."""

import base64
from typing import Final

from viser import theme

from app.i18n.speaking import tr
from app.text.templates import page_of_template
from app.theme import PALETTES

_LIGHT: Final = PALETTES["light"]


def _mark(ink: str, motto: str) -> str:
    svg = page_of_template("page/panels/title_bar.svg", ink=ink, motto=motto, brand=_LIGHT.brand, faint=_LIGHT.faint)
    return "data:image/svg+xml;base64," + base64.b64encode(svg.encode()).decode()


def titlebar() -> theme.TitlebarConfig:
    """Return viser's title bar with our mark for light and dark, in the visitor's language."""
    motto = tr("two arms, one gives way")
    return theme.TitlebarConfig(
        buttons=None,
        image=theme.TitlebarImage(
            image_url_light=_mark(_LIGHT.ink, motto),
            image_url_dark=_mark(PALETTES["dark"].ink, motto),
            image_alt=f"Duet: {motto}",
            href=None,
        ),
    )
