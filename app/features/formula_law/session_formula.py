"""A session's formula."""

import json
from typing import Final

from app.features.custom_law.student_law import StudentLaw, student_law
from app.features.formula_law.formula import BadFormula, Formula
from app.features.formula_law.formula_law import FormulaLaw
from app.features.formula_law.formula_tests import FormulaExamination
from app.session.parts import SessionPart
from app.session.session import Session
from app.settings import Settings

FIRST: Final = "where(d <= d_m, 1, 0) * (v + u)"
"""Initial text: a switch at d_m, which is not smooth."""

PAPER: Final = "where(d <= d_m, 1, (d_m / d)^n) * (v + u)"
"""The paper's law: c = λ (v + u) with λ of eq. (31)."""


class SessionFormula(SessionPart):
    """The formula that a visitor wrote. `text`: "" until a formula has run."""

    name = "formula_law"

    def __init__(self, session: Session) -> None:
        self._session = session
        self.text = ""
        self._law: FormulaLaw | None = None

    @property
    def possible(self) -> bool:
        """False while a custom law's file takes precedence."""
        law = self._session.law
        return not (isinstance(law, StudentLaw) and law.path is not None)

    @property
    def runs(self) -> bool:
        """True if it is the law of the run or its ghost."""
        law = self._session.law
        return self._law is not None and self._law in (law.of_run, law.of_ghost)

    def run(self, text: str) -> None:
        """Resets the run.

        Raises:
            BadFormula: nothing is changed.
        """
        self._take(text)
        self._session.assign_laws(True)

    def stop(self) -> None:
        """Resets the run; the text is kept."""
        if self.possible:
            self._law = None
            student_law(self._session).take(None)
            self._session.assign_laws(True)

    def _take(self, text: str) -> None:
        session = self._session
        law = FormulaLaw(Formula(text), lambda: session.settings.run.law)
        tests = (
            None if session.background is None else FormulaExamination(text, session.background, session.wake)
        )
        student_law(session).take(law, tests)
        self.text, self._law = text, law

    def changed(self, before: Settings, after: Settings, rebuilt: bool) -> None:
        del rebuilt
        chosen = before.run.law.law != after.run.law.law
        if (
            chosen
            and self._law is not None
            and self._session.law.of_run is self._law
            and not self._session.parts.lead
        ):
            self.stop()

    def saved(self) -> bytes:
        return json.dumps({"text": self.text, "runs": self._law is not None}).encode() if self.text else b""

    def restore(self, saved: bytes) -> None:
        try:
            about = json.loads(saved)
            text, runs = str(about["text"]), about["runs"] is True
            Formula(text)
        except (ValueError, TypeError, LookupError, BadFormula):
            return
        self.text = text
        if runs and self.possible:
            self._take(text)
            self._session.assign_laws(False)
