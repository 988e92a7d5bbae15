"""The paper's figures and ours."""

from collections.abc import Mapping
from pathlib import Path
from typing import Final

from app.feature import Command, Feature


def _commands() -> Mapping[str, Command]:
    from app.features.figures.command import Figures, draw_figures

    return {"figures": Command(Figures, draw_figures, "show")}


FIGURES: Final = Feature("figures", texts=Path(__file__).parent, commands=_commands)
