"""The page of feedback of one student: every test with its reason, what to try, and the run that failed as a picture."""

import re
from collections.abc import Sequence
from pathlib import Path

from markupsafe import Markup

from app.custom_law.arena import TrialCurve
from app.export.report_html import locked_page
from app.i18n.speaking import set_language, tr
from app.marks.mark_tables import StudentMarks
from app.plots.curve_chart import CurveAxis, Line, curve_chart
from app.settings import Language
from scenes.files import replacing


def write_feedback(folder: Path, students: Sequence[StudentMarks], language: Language) -> None:
    """Write a page for each student into a folder, which is made if there is none.

    Raises:
        OSError: it cannot be written.
    """
    set_language(language)
    folder.mkdir(parents=True, exist_ok=True)
    taken: set[str] = set()
    for marks in students:
        # Names come from files: they may hold any sign, and differ only in those that a system does not take.
        name = re.sub(r"[^\w -]+", "-", "-".join(filter(None, (marks.student.name[:80], marks.student.id))))
        while name.casefold() in taken:
            name += "+"
        taken.add(name.casefold())
        with replacing(folder / f"{name}.html") as new:
            new.write_text(feedback_page(marks), encoding="utf-8", newline="\n")


def feedback_page(marks: StudentMarks) -> str:
    """Return the page, which loads and runs nothing, in the language that is spoken here."""
    title = tr("What {name} handed in", name=marks.student.name)
    return locked_page("marks/feedback.html", title, ("report.css",), marks=marks, chart=_chart)


def _chart(curve: TrialCurve) -> Markup:
    values = [value for line in curve.lines.values() for value in line if value is not None]
    low, high = 1.1 * min((0.0, *values)), 1.2 * max((curve.limit or 0.0, *values)) + 1e-6
    symbol, unit, factor = {"d": ("d", "mm", 1e3), "e": ("|e|", "mm", 1e3), "dq_step": ("Δq̇", "rad/s", 1.0)}[curve.quantity]
    critical = curve.limit if curve.quantity == "d" else None
    over = CurveAxis("t", "s", 1.0, "", 0.0, max(curve.seconds, 1e-3))
    up = CurveAxis(symbol, unit, factor, "d" if curve.quantity == "d" else "", low, high, critical)
    dashes = ("", "5 4")
    lines = [Line(tuple(line), "", name, 2.0, dashes[i]) for i, (name, line) in enumerate(curve.lines.items())]
    if curve.limit is not None and critical is None:
        lines.insert(0, Line((curve.limit,) * len(next(iter(curve.lines.values()))), "dm", tr("limit"), 1.5, "2 4"))
    return curve_chart(over, up, tuple(lines), f"{symbol}(t)")
