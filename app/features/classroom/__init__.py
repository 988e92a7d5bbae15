from pathlib import Path
from typing import TYPE_CHECKING, Final

from app.feature import Feature

STATIC: Final = Path(__file__).parent / "static"

if TYPE_CHECKING:
    from app.web.pages import PageAssets


def _assets() -> "PageAssets":
    from app.web.pages import PageAssets

    return PageAssets((), (STATIC / "class.css",))


CLASSROOM: Final = Feature("classroom", texts=Path(__file__).parent, assets=_assets)
