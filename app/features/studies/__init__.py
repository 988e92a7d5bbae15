"""Studies of a run."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

from app.feature import Command, Feature
from app.plots.chart_list import Charts

if TYPE_CHECKING:
    from app.page.panel_context import PanelMaker


def _commands() -> Mapping[str, Command]:
    from app.features.studies.search_commands import Falsify, Hunt, falsify, hunt

    return {"hunt": Command(Hunt, hunt, "compute"), "falsify": Command(Falsify, falsify, "compute")}


def _panels() -> "Sequence[PanelMaker]":
    from app.features.studies.compare import ComparePanel
    from app.features.studies.microscope_buttons import MicroscopeButtons

    return ComparePanel, MicroscopeButtons


def _charts() -> Charts:
    from app.features.studies.charts import CHARTS

    return CHARTS


STUDIES: Final = Feature(
    "studies", texts=Path(__file__).parent, commands=_commands, panels=_panels, charts=_charts
)
