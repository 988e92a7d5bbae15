"""The marks as files: a table of all that was handed in, one row a student for Moodle or Canvas, and the result of one at Gradescope."""

import json
from collections.abc import Sequence
from itertools import groupby
from pathlib import Path
from typing import Final, NamedTuple

from app.custom_law.trials import TRIALS
from app.export.report_record import StepRecord
from app.marks.graded_file import REPORT, GradedFile, Student, points_of
from scenes.files import csv_text


class StudentMarks(NamedTuple):
    """All that one student handed in; of several laws the best one counts, and a step in several reports counts once, the best."""

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
        return " | ".join(f"{Path(file.name).name}: {file.feedback}".removesuffix(": ") for file in self.files)


def by_student(rows: Sequence[GradedFile]) -> list[StudentMarks]:
    """Return the files of each student, sorted by name."""
    ordered = sorted(rows, key=lambda row: row.student)
    return [StudentMarks(student, tuple(files)) for student, files in groupby(ordered, key=lambda row: row.student)]


def write_marks(path: Path, rows: Sequence[GradedFile]) -> None:
    """Write the table with one row a file."""
    head = ("name", "kind", *TRIALS, *REPORT, "points", "reason", "student", "id", "maximum", "feedback")
    values = [
        (
            *(row.name, row.kind, *(row.cells.get(key, "") for key in (*TRIALS, *REPORT)), _number(row.points), row.reason),
            *(*row.student, _number(row.maximum), row.feedback),
        )
        for row in rows
    ]
    _write(path, [head, *values])


def write_moodle(path: Path, students: Sequence[StudentMarks]) -> None:
    """Write a grading worksheet of Moodle's: the columns that its assignment reads, and finds a student by."""
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
    """Write a table for Canvas' gradebook, which finds a student by ID, and takes numbers alone."""
    most = max((one.maximum for one in students), default=0.0)
    rows = [(one.student.name, one.student.id, "", _number(one.points)) for one in students]
    _write(path, [("Student", "ID", "Section", "Duet"), ("Points Possible", "", "", _number(most)), *rows])


def write_gradescope(path: Path, students: Sequence[StudentMarks]) -> None:
    """Write the `results.json` of one submission, all files together: a test for each of a law's, and one for each other file."""
    rows = [row for one in students for row in one.files]
    tests: list[dict[str, object]] = []
    for row in rows:
        tested = [one for one in row.remarks if one.passed is not None] if row.kind == "law" else []
        words = " ".join(one.text for one in row.remarks if one.passed is None)
        for one in tested:
            marks = {"score": one.points, "max_score": one.maximum, "status": "passed" if one.passed else "failed"}
            tests.append({"name": f"{row.name}: {one.name}", "output": f"{one.text} {one.more}".strip(), **marks})
        if not tested or words:
            of_file = {} if tested else {"score": row.points, "max_score": row.maximum}
            tests.append({"name": row.name, "output": words if tested else row.feedback, **of_file})
    total = {"score": StudentMarks(Student("", ""), tuple(rows)).points, "output_format": "text", "tests": tests}
    path.write_text(json.dumps(total, indent=1, ensure_ascii=False) + "\n", encoding="utf-8", newline="\n")


WRITERS: Final = {"moodle": write_moodle, "canvas": write_canvas, "gradescope": write_gradescope}
"""Option → what writes its file, from all that was handed in."""


def _number(value: float) -> str:
    return f"{value:.10g}"


def _write(path: Path, rows: Sequence[Sequence[object]]) -> None:
    path.write_text(csv_text(rows), encoding="utf-8", newline="\n")
