"""The six tests of a formula."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from time import perf_counter

import numpy as np

from app.features.custom_law import template
from app.features.custom_law.arena import CRITICAL_DISTANCE, TrialResult
from app.features.custom_law.examination import Examination
from app.features.custom_law.trials import verdict_on
from app.features.formula_law.formula import Formula
from app.features.formula_law.formula_law import FILE, FormulaLaw
from app.runtime.job_pool import Jobs
from controllers.kinematics import Array
from controllers.laws.situation import Situation
from scenes.settings import LawSettings
from scenes.wanted import check_wanted


def examine_formula(text: str, name: str) -> TrialResult:
    """Verdict of one test with d_m = 0.15 m, n = 6 and v = 0.30 m/s, in its own process."""
    law = _TimedFormula(Formula(text))
    return replace(verdict_on(law, name), as_template=law.as_template)


class _TimedFormula(FormulaLaw):
    """Times its calls and stops on request."""

    def __init__(self, formula: Formula) -> None:
        settings = LawSettings(critical_distance=CRITICAL_DISTANCE)
        super().__init__(formula, lambda: settings)
        self.as_template = True
        self.seconds = float("nan")

    def __call__(self, situation: Situation) -> Array:
        check_wanted()
        begin = perf_counter()
        velocities = super().__call__(situation)
        self.seconds = perf_counter() - begin
        self.as_template &= np.allclose(velocities, template.law(situation), rtol=1e-6, atol=1e-9)
        return velocities


class FormulaExamination(Examination):
    """Tests of a visitor's formula."""

    def __init__(self, text: str, background: Jobs, wake: Callable[[], None]) -> None:
        super().__init__(Path(), background, wake)
        self.progress = self._none = self._none._replace(file=FILE, typed=True)
        self._text = text

    def _one_test(self) -> tuple[Callable[..., TrialResult], tuple[object, ...], str]:
        return examine_formula, (self._text,), ""
