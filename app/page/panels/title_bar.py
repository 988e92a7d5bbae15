"""The title bar: our name and mark, drawn by us; and the theme of viser's widgets below it."""

import base64
from typing import Final

import viser
from viser.theme import TitlebarConfig, TitlebarImage

from app.i18n.speaking import tr
from app.settings import Theme
from app.text.templates import page_of_template
from app.theme import BRAND, PALETTES

_LIGHT: Final = PALETTES["light"]


def _mark(ink: str, motto: str) -> str:
    svg = page_of_template("page/panels/title_bar.svg", ink=ink, motto=motto, brand=_LIGHT.brand, faint=_LIGHT.faint)
    return "data:image/svg+xml;base64," + base64.b64encode(svg.encode()).decode()


def configure_theme(gui: viser.GuiApi, theme: Theme) -> None:
    """Give a page our title bar, and viser's widgets the theme and our colour."""
    gui.configure_theme(
        titlebar_content=titlebar(),
        dark_mode=theme == "dark",
        show_logo=False,
        show_share_button=False,
        brand_color=BRAND,
    )


def titlebar() -> TitlebarConfig:
    """Return viser's title bar with our mark for light and dark, in the visitor's language."""
    motto = tr("two arms, one gives way")
    return TitlebarConfig(
        buttons=None,
        image=TitlebarImage(
            image_url_light=_mark(_LIGHT.ink, motto),
            image_url_dark=_mark(PALETTES["dark"].ink, motto),
            image_alt=f"Duet: {motto}",
            href=None,
        ),
    )
