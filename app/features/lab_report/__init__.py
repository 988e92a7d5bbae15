from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

from app.feature import Feature

if TYPE_CHECKING:
    from app.page.panel_context import PanelMaker


def _panels() -> "Sequence[PanelMaker]":
    from app.features.lab_report.lab_report_box import LabReportBox

    return (LabReportBox,)


LAB_REPORT: Final = Feature("lab_report", texts=Path(__file__).parent, panels=_panels)
