from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

from app.feature import Feature

if TYPE_CHECKING:
    from app.features.formula_law.formula_editor import FormulaEditor
    from app.page.panel_context import PanelContext, PanelMaker


def _editor(page: "PanelContext") -> "FormulaEditor | None":
    from app.features.custom_law.law_editor import LawEditor
    from app.features.formula_law.formula_editor import FormulaEditor
    from app.features.formula_law.session_formula import SessionFormula

    # A page has one editor; the editor of a custom law's file can do more.
    if (
        any(isinstance(panel, LawEditor) for panel in page.made)
        or not page.session.parts.of(SessionFormula).possible
    ):
        return None
    return FormulaEditor(page)


def _panels() -> "Sequence[PanelMaker]":
    return (_editor,)


FORMULA_LAW: Final = Feature("formula_law", texts=Path(__file__).parent, panels=_panels)
