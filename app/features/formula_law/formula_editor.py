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
from app.text.first_task_texts import in_symbols, wording
from app.text.templates import macros
from app.web.control_events import on_press
from scenes.quantities import DISTANCE

WORDS: Final = {
    "run": N_("Run the formula"),
    "how": N_("Ctrl+Enter runs it. Tab indents; Esc, then Tab leaves."),
    "saving": N_("Reading the formula …"),
    "unsaved": N_("Not run yet."),
    "saved": N_("It runs together with the paper’s law."),
    "fails": N_("It was read, but it does not run."),
    "large": N_("This formula is too long."),
}


GIVES: Final = N_("It gives c in m/s: how much faster than the task alone the arm leaves the obstacle.")

GIVES_OF_A_VALUE: Final = N_("It gives c in m/s: how much faster than with the task alone d rises.")
"""For a first task that is not a distance."""

CALLED: Final = N_("d is the distance, u the pull of the task, w the approach of the obstacle.")

CALLED_OF_A_VALUE: Final = N_(
    "In a formula, d is the value {symbol}, u how fast the task alone lowers it, w how fast it falls by what is not the arm."
)
"""For a first task that is not a distance; a formula calls it d."""


class StopFormula(Action):
    """Return to the law of the settings."""


class FormulaText(LawText):
    """A session's formula, for the editor."""

    name = "formula"
    words = WORDS
    most = MOST_CHARACTERS
    rows = 4

    def __init__(self, session: Session) -> None:
        self._session, self._formula = session, session.parts.of(SessionFormula)
        self._written = ""

    @property
    def offered(self) -> bool:
        return self._formula.possible

    def title(self) -> str:
        return tr("formula")

    def place(self) -> Markup:
        kept = self._session.settings.run.quantity
        gives = in_symbols(tr(wording(GIVES, kept, {GIVES: GIVES_OF_A_VALUE})), kept)
        row, names = in_symbols(Markup("J<sub>d</sub>"), kept), tr(CALLED)
        if not (kept is DISTANCE or kept.against):
            names = tr(CALLED_OF_A_VALUE, symbol=kept.symbol)
        return macros("features/formula_law/formula.html").place(COMMANDS, gives, row, names)

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
    """It also leads back to the law of the settings."""

    def __init__(self, page: PanelContext) -> None:
        super().__init__(page, FormulaText(page.session))
        self._formula = page.session.parts.of(SessionFormula)
        self._quantity = page.session.settings.run.quantity
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
        if (kept := frame.live.settings.run.quantity) is not self._quantity:
            self._quantity = kept
            for places in (self._compare, self._in_task):
                if places is not None:
                    places[0].content = self._text.place()
        self._stop.visible = self._formula.runs and not self._session.parts.lead
