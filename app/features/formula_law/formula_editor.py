"""The editor of a formula on the page."""

import hashlib
from typing import Final

import viser
from markupsafe import Markup

from app.features.custom_law.edited_file import Version
from app.features.custom_law.law_editor import LawEditor, LawText
from app.features.custom_law.law_html import COMMANDS
from app.features.formula_law.formula import MOST_CHARACTERS, Formula
from app.features.formula_law.session_formula import FIRST, SessionFormula
from app.i18n.speaking import N_, tr
from app.page.panel_context import PanelContext
from app.session.actions import Action
from app.session.frame import Frame
from app.session.session import Session
from app.text.templates import macros
from app.web.control_events import on_press

WORDS: Final = {
    "run": N_("Run the formula"),
    "how": N_("Ctrl+Enter runs it. Tab indents; Esc, then Tab leaves."),
    "saving": N_("Reading the formula …"),
    "unsaved": N_("Not run yet."),
    "saved": N_("It runs beside the paper’s law."),
    "fails": N_("It was read, but it does not run."),
    "large": N_("This formula is too long."),
}
"""Words of the editor's script that differ from those for a file."""


class StopFormula(Action):
    """Return to the law of the settings."""


class FormulaText(LawText):
    """A session's formula, as the editor needs it."""

    name = "formula"
    words = WORDS
    most = MOST_CHARACTERS
    rows = 4

    def __init__(self, session: Session) -> None:
        self._formula = session.parts.of(SessionFormula)
        self._written = ""

    @property
    def offered(self) -> bool:
        return self._formula.possible

    def title(self) -> str:
        return tr("formula")

    def place(self) -> Markup:
        return macros("features/formula_law/formula.html").place(COMMANDS)

    def read(self) -> Version:
        text = self._formula.text
        return Version(text, _hash(text)) if text else Version(FIRST, "")

    def save(self, text: str, base: str) -> Version:
        del base
        Formula(text)
        self._written = text
        return Version(text, _hash(text))

    def run(self) -> None:
        self._formula.run(self._written)


def _hash(text: str) -> str:
    return hashlib.sha256(text.encode("utf-8", "replace")).hexdigest()


class FormulaEditor(LawEditor):
    """The operator's formula editor, with the way back to the law of the settings."""

    def __init__(self, page: PanelContext) -> None:
        super().__init__(page, FormulaText(page.session))
        self._formula = page.session.parts.of(SessionFormula)
        with page.controls.compare_tab:
            self._stop = page.client.gui.add_button(
                tr("Back to the law of the settings"),
                icon=viser.Icon.ARROW_BACK_UP,
                color="gray",
                visible=False,
            )
        on_press(self._stop, lambda: page.session.post(StopFormula()))
        page.handlers.add(StopFormula, lambda _: self._formula.stop())

    def show(self, frame: Frame) -> None:
        super().show(frame)
        self._stop.visible = self._formula.runs and not self._session.parts.lead
