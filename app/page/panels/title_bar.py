"""The title bar: our name and mark, drawn by us."""

import base64
import html
from functools import cache

from viser import theme

from app.i18n.speaking import tr


def _mark(ink: str, motto: str) -> str:
    svg = (
        '<svg xmlns="http://www.w3.org/2000/svg" width="340" height="34" viewBox="0 0 340 34" fill="none" stroke-width="4.2" '
        'stroke-linecap="round" stroke-linejoin="round"><path d="M5 29V19L14 9l8 6" stroke="#f26a0a"/>'
        '<path d="M43 29V19L34 7l-6 9" stroke="#8a949e"/>'
        f'<g fill="{ink}"><circle cx="5" cy="19" r="2.6"/><circle cx="14" cy="9" r="2.6"/><circle cx="43" cy="19" r="2.6"/>'
        f'<circle cx="34" cy="7" r="2.6"/></g><g fill="{ink}" font-family="system-ui,Segoe UI,Roboto,Liberation Sans,sans-serif">'
        '<text x="58" y="23" font-size="19" font-weight="700">Duet<tspan dx="12" font-size="14" font-weight="400" opacity=".65">'
        f"{html.escape(motto)}</tspan></text></g></svg>"
    )
    return "data:image/svg+xml;base64," + base64.b64encode(svg.encode()).decode()


def titlebar() -> theme.TitlebarConfig:
    """Return viser's title bar with our mark for light and dark, in the visitor's language."""
    return _titlebar(tr("two arms, one gives way"))


@cache
def _titlebar(motto: str) -> theme.TitlebarConfig:
    return theme.TitlebarConfig(
        buttons=None,
        image=theme.TitlebarImage(
            image_url_light=_mark("#24292f", motto),
            image_url_dark=_mark("#f0f3f6", motto),
            image_alt=f"Duet: {motto}",
            href=None,
        ),
    )
