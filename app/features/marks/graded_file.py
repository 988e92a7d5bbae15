"""One hand-in and its points."""

import ast
import re
import threading
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Final, NamedTuple

from app.features.custom_law.arena import TrialCurve
from app.features.custom_law.custom_law import LARGEST
from app.features.custom_law.law_file import quoted
from app.features.custom_law.trials import GATES, TRIALS, advice
from app.features.lab_report.report_html import LARGEST_REPORT, StepRecord, read_records
from app.features.lessons.loading import load_lessons
from app.features.marks.fence import FenceLimits
from app.features.marks.marked import LawMarks, marked
from app.i18n.speaking import set_language, tr
from app.settings import Language
from controllers.errors import BadSetting, DuetError
from scenes.files import read_file, readable

KINDS: Final = {".py": "law", ".html": "report", ".htm": "report"}

REPORT: Final = ("steps", "predictions", "right", "challenges", "passed", "attempts")

_MOODLE: Final = re.compile(r"(?P<name>.+)_(?P<id>\d+)_assignsubmission_file_?.*")
_CANVAS: Final = re.compile(r"(?P<name>[^_]+)(?:_LATE)?_(?P<id>\d+)_\d+_.+")
"""Student's folder or file, as Moodle and Canvas name it."""


class Student(NamedTuple):
    """Student from a file's name. `id`: in Moodle or Canvas, or ""."""

    name: str
    id: str


class Remark(NamedTuple):
    """Feedback on one test, question or challenge.

    Attributes:
        passed: None for the whole file.
        text: the reason.
        more: advice.
        curve: of the failed run, or None.
    """

    name: str
    passed: bool | None
    text: str
    points: float = 0.0
    maximum: float = 0.0
    more: str = ""
    curve: TrialCurve | None = None


@dataclass
class GradedFile:
    """One row of the table.

    Attributes:
        isolation: see `LawMarks`.
        full_marks: text if nothing failed, else "".
    """

    name: str
    kind: str
    student: Student
    cells: dict[str, object] = field(default_factory=dict)
    points: float = 0.0
    maximum: float = 0.0
    reason: str = ""
    remarks: list[Remark] = field(default_factory=list)
    isolation: str = ""
    records: tuple[StepRecord, ...] = ()
    full_marks: str = ""

    @property
    def feedback(self) -> str:
        """Failures with advice, or that nothing failed."""
        failed: dict[str, list[str]] = {}
        for one in self.remarks:
            if not one.passed:
                failed.setdefault(f"{one.text} {one.more}".strip(), []).append(one.name)
        return (
            " ".join(
                f"{', '.join(filter(None, names))}: {said}".removeprefix(": ")
                for said, names in failed.items()
            )
            or self.reason
            or self.full_marks
        )


def weights_of(points: Sequence[float]) -> dict[str, float]:
    """Test → points. `points`: in the tests' order; () for one each.

    Raises:
        BadSetting: not six numbers ≥ 0, or all are 0.
    """
    values = tuple(points) or (1.0,) * len(TRIALS)
    if len(values) != len(TRIALS) or not all(0.0 <= value <= 1e6 for value in values) or not any(values):
        raise BadSetting(
            f"points needs {len(TRIALS)} numbers from 0, one a test ({', '.join(TRIALS)}), not all of them 0."
        )
    return dict(zip(TRIALS, values, strict=True))


def student_of(path: Path) -> Student:
    """`path`: below the graded folder; its first folder names the student, or else the file."""
    first = readable(path.parts[0] if len(path.parts) > 1 else path.name)
    if found := _MOODLE.fullmatch(first) or _CANVAS.fullmatch(first):
        return Student(found["name"], found["id"])
    return Student(first if len(path.parts) > 1 else Path(first).stem, "")


def graded(
    path: Path,
    folder: Path,
    limits: FenceLimits,
    stopped: threading.Event,
    weights: Mapping[str, float],
    language: Language = "en",
) -> GradedFile:
    """Grade a file. A bad file gives a row with a reason, never an exception.

    Raises:
        DuetError: this computer cannot grade it.
    """
    set_language(language)
    below = path.relative_to(folder)
    kind = KINDS[path.suffix.lower()]
    row = GradedFile(readable(str(below)), kind, student_of(below))
    row.maximum = sum(weights.values()) if kind == "law" else 0.0
    if path.is_symlink():
        row.reason = tr("a link, not a file")
        return row
    try:
        text = read_file(path, LARGEST if kind == "law" else LARGEST_REPORT)
    except OSError as error:
        row.reason = tr("cannot be read ({reason})", reason=error.strerror or error)
        return row
    try:
        if kind == "law":
            _take_marks(
                row, text, marked(readable(path.name), text, limits, stopped.is_set, language), weights
            )
        else:
            _take_records(row, read_records(text))
    except OSError as error:
        # Not the file's fault, such as a full disk.
        raise DuetError(
            f"{row.name}: grading it failed ({error.strerror or error}); mend this, and grade again."
        ) from None
    except Exception as error:
        # Only this file's row is lost.
        row.reason = tr(str(error)) or type(error).__name__
    return row


def _take_marks(row: GradedFile, text: bytes, marks: LawMarks, weights: Mapping[str, float]) -> None:
    row.isolation = marks.isolation
    verdicts = tuple(marks.verdicts.values())
    passed, failed = {one.name for one in verdicts if one.passed}, [one for one in verdicts if not one.passed]
    row.cells |= {one.name: "pass" if one.passed else "fail" for one in verdicts}
    same: defaultdict[str, list[str]] = defaultdict(list)
    for one in failed:
        same[one.reason].append(one.name)
    whole: list[str] = []
    untouched, gated = marks.as_template, not passed.issuperset(GATES)
    if untouched:
        whole.append(
            tr(
                "In every situation of the tests this law answers as the template of `lwr-duet new-law`, so it has no points."
            )
        )
    elif gated and passed:
        gates = " & ".join(tr(gate) for gate in GATES)
        whole.append(tr("The other tests count only for a law that passes these: {gates}.", gates=gates))
    if marks.ended:
        whole.append(tr(marks.ended))
    own = [one for one in failed if one.reason.startswith(Path(row.name).name)]
    if not untouched and len(own) < len(failed):
        whole += returned_line(text)
    row.remarks = [Remark("", None, said) for said in whole]
    for one in verdicts:
        points = (
            weights[one.name] if one.passed and not untouched and (one.name in GATES or not gated) else 0.0
        )
        mend = tr("Correct this line; `lwr-duet law-test` says whether it runs, before you hand it in.")
        more = "" if one.passed else mend if one in own else tr(advice(one.name))
        row.remarks.append(
            Remark(tr(one.name), one.passed, one.reason, points, weights[one.name], more, one.curve)
        )
        row.points += points
    if not untouched and len(passed) == len(TRIALS):
        row.full_marks = tr("All six tests are passed.")
    row.reason = "; ".join(
        (*(f"{', '.join(map(tr, names))}: {reason}" for reason, names in same.items()), *whole)
    )


def returned_line(text: bytes) -> tuple[str, ...]:
    """Sentence with the line of the last return of `law`, or ()."""
    try:
        body = ast.parse(text).body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return ()
    found = [node for node in body if isinstance(node, ast.FunctionDef) and node.name == "law"]
    lines = [node.lineno for node in ast.walk(found[-1]) if isinstance(node, ast.Return)] if found else []
    if not lines:
        return ()
    return (
        tr(
            "Your law gives its result on line {line}{quoted}.",
            line=max(lines),
            quoted=tr(quoted(text, max(lines))),
        ),
    )


def _take_records(row: GradedFile, records: tuple[StepRecord, ...]) -> None:
    predicted = [record for record in records if record.prediction is not None]
    challenges = [record for record in records if record.passed is not None]
    right, passed = (
        sum(record.right is True for record in predicted),
        sum(record.passed is True for record in challenges),
    )
    counts = (
        len(records),
        len(predicted),
        right,
        len(challenges),
        passed,
        sum(record.attempts for record in records),
    )
    row.cells |= zip(REPORT, counts, strict=True)
    row.records = records
    row.points, row.maximum = points_of(records)
    for r in predicted:
        if not r.right:
            what = tr("not right") if r.right is False else tr("open")
            said = tr("answer {answer} is {what}", answer=r.prediction, what=what)
            row.remarks.append(Remark(f"{r.lesson}/{r.step}", False, said))
    for r in challenges:
        if not r.passed:
            said = tr("challenge not passed in {attempts} attempts", attempts=r.attempts)
            row.remarks.append(Remark(f"{r.lesson}/{r.step}", False, said))
    row.reason = "; ".join(f"{one.name}: {one.text}" for one in row.remarks)
    if row.points == row.maximum > 0:
        row.full_marks = tr("Every prediction is right, and every challenge is passed.")


def points_of(records: Sequence[StepRecord]) -> tuple[int, int]:
    """Points and maximum; of repeated ones the best counts."""
    predicted = [
        (record.lesson, record.step, record.right is True)
        for record in records
        if record.prediction is not None
    ]
    challenges = [
        (record.lesson, record.step, record.passed is True) for record in records if record.passed is not None
    ]
    points = sum(len({one for one in kind if one[2]}) for kind in (predicted, challenges))
    known = _lessons()
    others = sum(len({one[:2] for one in kind if one[0] not in known}) for kind in (predicted, challenges))
    return points, others + sum(known.get(lesson, 0) for lesson in {record.lesson for record in records})


@cache
def _lessons() -> dict[str, int]:
    return {
        lesson.id: len(
            [asked for step in lesson.steps for asked in (step.question, step.challenge) if asked is not None]
        )
        for lesson in load_lessons().lessons
    }
