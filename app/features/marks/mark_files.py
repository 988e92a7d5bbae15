"""Marks as tables and feedback pages."""

import json
import re
from collections.abc import Sequence
from itertools import groupby
from pathlib import Path
from typing import Final, NamedTuple

from markupsafe import Markup

from app.features.custom_law.arena import TrialCurve
from app.features.custom_law.trials import TRIALS
from app.features.lab_report.report_html import SHEET, StepRecord, locked_page
from app.features.marks.graded_file import REPORT, GradedFile, Student, points_of
from app.i18n.speaking import set_language, tr
from app.plots.curve_chart import CurveAxis, Line, curve_chart
from app.settings import Language
from scenes.files import csv_text, replacing


class StudentMarks(NamedTuple):
    """Hand-ins of one student; the best law and the best of each repeated step count."""

    student: Student
    files: tuple[GradedFile, ...]

    @property
    def points(self) -> float:
        return max((file.points for file in self._laws), default=0.0) + points_of(self._records)[0]

    @property
    def maximum(self) -> float:
        return max((file.maximum for file in self._laws), default=0.0) + points_of(self._records)[1]

    @property
    def _laws(self) -> list[GradedFile]:
        return [file for file in self.files if file.kind == "law"]

    @property
    def _records(self) -> list[StepRecord]:
        return [record for file in self.files for record in file.records]

    @property
    def feedback(self) -> str:
        return " | ".join(
            f"{Path(file.name).name}: {file.feedback}".removesuffix(": ") for file in self.files
        )


def by_student(rows: Sequence[GradedFile]) -> list[StudentMarks]:
    ordered = sorted(rows, key=lambda row: row.student)
    return [
        StudentMarks(student, tuple(files))
        for student, files in groupby(ordered, key=lambda row: row.student)
    ]


def write_marks(path: Path, rows: Sequence[GradedFile]) -> None:
    head = ("name", "kind", *TRIALS, *REPORT, "points", "reason", "student", "id", "maximum", "feedback")
    values = [
        (
            *(
                row.name,
                row.kind,
                *(row.cells.get(key, "") for key in (*TRIALS, *REPORT)),
                _number(row.points),
                row.reason,
            ),
            *(*row.student, _number(row.maximum), row.feedback),
        )
        for row in rows
    ]
    _write(path, [head, *values])


def write_moodle(path: Path, students: Sequence[StudentMarks]) -> None:
    head = ("Identifier", "Full name", "Grade", "Maximum Grade", "Last modified (grade)", "Feedback comments")
    rows = [
        (
            *(f"Participant {one.student.id}" if one.student.id else "", one.student.name),
            *(_number(one.points), _number(one.maximum), "", one.feedback),
        )
        for one in students
    ]
    _write(path, [head, *rows])


def write_canvas(path: Path, students: Sequence[StudentMarks]) -> None:
    """Canvas identifies students by ID, and accepts only numbers."""
    most = max((one.maximum for one in students), default=0.0)
    rows = [(one.student.name, one.student.id, "", _number(one.points)) for one in students]
    _write(path, [("Student", "ID", "Section", "Duet"), ("Points Possible", "", "", _number(most)), *rows])


def write_gradescope(path: Path, students: Sequence[StudentMarks]) -> None:
    """Write `results.json`: each test of a law, and each other file."""
    rows = [row for one in students for row in one.files]
    tests: list[dict[str, object]] = []
    for row in rows:
        tested = [one for one in row.remarks if one.passed is not None] if row.kind == "law" else []
        words = " ".join(one.text for one in row.remarks if one.passed is None)
        for one in tested:
            marks = {
                "score": one.points,
                "max_score": one.maximum,
                "status": "passed" if one.passed else "failed",
            }
            tests.append(
                {"name": f"{row.name}: {one.name}", "output": f"{one.text} {one.more}".strip(), **marks}
            )
        if not tested or words:
            of_file = {} if tested else {"score": row.points, "max_score": row.maximum}
            tests.append({"name": row.name, "output": words if tested else row.feedback, **of_file})
    total = {
        "score": StudentMarks(Student("", ""), tuple(rows)).points,
        "output_format": "text",
        "tests": tests,
    }
    path.write_text(json.dumps(total, indent=1, ensure_ascii=False) + "\n", encoding="utf-8", newline="\n")


WRITERS: Final = {"moodle": write_moodle, "canvas": write_canvas, "gradescope": write_gradescope}


def _number(value: float) -> str:
    return f"{value:.10g}"


def _write(path: Path, rows: Sequence[Sequence[object]]) -> None:
    path.write_text(csv_text(rows), encoding="utf-8", newline="\n")


def write_feedback(folder: Path, students: Sequence[StudentMarks], language: Language) -> None:
    """Creates the folder; raises `OSError`."""
    set_language(language)
    folder.mkdir(parents=True, exist_ok=True)
    taken: set[str] = set()
    for marks in students:
        # Names from files may hold any character, and may differ only in those that a system does not allow.
        name = re.sub(r"[^\w -]+", "-", "-".join(filter(None, (marks.student.name[:80], marks.student.id))))
        while name.casefold() in taken:
            name += "+"
        taken.add(name.casefold())
        with replacing(folder / f"{name}.html") as new:
            new.write_text(feedback_page(marks), encoding="utf-8", newline="\n")


def feedback_page(marks: StudentMarks) -> str:
    """Page that loads and runs nothing, in the current language."""
    title = tr("What {name} handed in", name=marks.student.name)
    return locked_page("features/marks/feedback.html", title, (SHEET,), marks=marks, chart=_chart)


def _chart(curve: TrialCurve) -> Markup:
    values = [value for line in curve.lines.values() for value in line if value is not None]
    low, high = 1.1 * min((0.0, *values)), 1.2 * max((curve.limit or 0.0, *values)) + 1e-6
    symbol, unit, factor = {"d": ("d", "mm", 1e3), "e": ("|e|", "mm", 1e3), "dq_step": ("Δq̇", "rad/s", 1.0)}[
        curve.quantity
    ]
    critical = curve.limit if curve.quantity == "d" else None
    over = CurveAxis("t", "s", 1.0, "", 0.0, max(curve.seconds, 1e-3))
    up = CurveAxis(symbol, unit, factor, "d" if curve.quantity == "d" else "", low, high, critical)
    dashes = ("", "5 4")
    lines = [
        Line(tuple(line), "", name, 2.0, dashes[i]) for i, (name, line) in enumerate(curve.lines.items())
    ]
    if curve.limit is not None and critical is None:
        lines.insert(
            0, Line((curve.limit,) * len(next(iter(curve.lines.values()))), "dm", tr("limit"), 1.5, "2 4")
        )
    return curve_chart(over, up, tuple(lines), f"{symbol}(t)")
