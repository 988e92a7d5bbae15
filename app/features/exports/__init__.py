"""Jobs are top-level functions of plain data: `app.runtime.job_pool` runs them in other processes."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

from app.feature import Feature

if TYPE_CHECKING:
    from app.page.panel_context import PanelMaker


def _panels() -> "Sequence[PanelMaker]":
    from app.features.exports.exports_panel import ExportsPanel

    return (ExportsPanel,)


EXPORTS: Final = Feature("exports", texts=Path(__file__).parent, panels=_panels)
