"""State and tests of a custom law on the page."""

from typing import Final

from markupsafe import Markup

from app.features.custom_law.examination import ExaminationProgress
from app.features.custom_law.trials import TRIALS, WHY, advice
from app.text.templates import macros

COMMANDS: Final = ("lwr-duet new-law my_law.py", "lwr-duet serve --law-file my_law.py --edit-law")


def law_html(
    progress: ExaminationProgress, problem: str, away: bool, passed: bool = False, edits: bool = False
) -> Markup:
    """State of a custom law, in a lesson and in the tab on comparisons.

    `problem`: reason why the arm is frozen, or "".
    """
    template = macros("features/custom_law/law_tests.html")
    return template.law(progress, problem, away, passed, edits, TRIALS, WHY, advice, COMMANDS)
