from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

from app.feature import Feature

STATIC: Final = Path(__file__).parent / "static"

if TYPE_CHECKING:
    from app.page.panel_context import PanelMaker
    from app.page.view import View, ViewPart
    from app.web.pages import PageAssets


def _panels() -> "Sequence[PanelMaker]":
    from app.features.lever.lever_panel import LeverPanel

    return (LeverPanel,)


def _overlays() -> "Sequence[Callable[[View], ViewPart]]":
    from app.features.lever.card_lever import CardLever

    return (CardLever,)


def _assets() -> "PageAssets":
    from app.web.pages import PageAssets

    return PageAssets((STATIC / "contact_lever.js",), (STATIC / "lever.css",))


LEVER: Final = Feature(
    "lever", texts=Path(__file__).parent, panels=_panels, overlays=_overlays, assets=_assets
)
