"""What a class leaves behind as a table: one row a question and round, one row a challenge, and one column a report that was handed in."""

from collections.abc import Callable, Iterator, Sequence
from typing import Final

from app.export.class_report import report_names
from app.export.class_summary import ClassSummary, HandIn
from app.export.gain import Gain, gains, whole
from app.i18n.speaking import set_language
from app.lessons.lesson import MOST_CHOICES, Lesson
from app.lessons.progress import StepProgress, from_json
from app.lessons.tally import QuestionId
from scenes.files import csv_text
from scenes.rerun import never

COLUMNS: Final = (
    *("lesson", "step", "kind", "round", "students", "drawn"),
    *(f"answer_{i + 1}" for i in range(MOST_CHOICES)),
    *("right_answer", "right", "passed", "before", "after", "gain"),
)
"""Of every row; after them stands a column for each report."""


def class_table_bytes(summary: ClassSummary, lessons: Sequence[Lesson], stopped: Callable[[], bool] = never) -> bytes:
    """Return the table as CSV in UTF-8, with the mark by which spreadsheets know it; for the columns see `app/documents/class.md`."""
    del stopped
    set_language("en")
    found = (*_rows(summary, lessons), *_gain_rows(summary, lessons))
    rows = ([*(cells.get(column, "") for column in COLUMNS), *marks] for cells, marks in found)
    return csv_text([(*COLUMNS, *report_names(summary.hand_ins)), *rows], "\r\n").encode("utf-8-sig")


_Row = tuple[dict[str, object], list[object]]
"""Cells by column, and one for each report."""


def _rows(summary: ClassSummary, lessons: Sequence[Lesson]) -> Iterator[_Row]:
    asked = summary.asked_in(lessons)
    done = [from_json(report.progress).steps for report in summary.hand_ins]
    for lesson in lessons:
        for step in lesson.steps:
            question = lesson.id, step.id
            about: dict[str, object] = {"lesson": lesson.id, "step": step.id}
            if question in asked and step.question is not None:
                right = step.question.right
                for number, tally in enumerate(asked[question].rounds, 1):
                    counts = {f"answer_{i + 1}": count for i, count in enumerate(tally.counts)}
                    more = {"right_answer": right + 1, "right": tally.counts[right]}
                    cells = {"kind": "question", "round": number, "students": tally.handed_in, "drawn": len(tally.curves)}
                    yield about | cells | counts | more, [_answer(one, question, number) for one in summary.hand_ins]
            if step.challenge is not None and _tried(question, summary, done):
                marks: list[object] = [int(steps[question].passed) if question in steps else "" for steps in done]
                yield about | {"kind": "challenge", "passed": summary.passed.get(question, 0)}, marks


def _gain_rows(summary: ClassSummary, lessons: Sequence[Lesson]) -> Iterator[_Row]:
    """Yield a row a question that was asked before and after, and below it one for each answer before: how many gave which one after."""
    questions, marks = gains(summary.paired, lessons), list[object]([""] * len(summary.hand_ins))
    for one in questions:
        about: dict[str, object] = {"lesson": one.lesson.id, "step": one.step.id, "right_answer": one.right + 1}
        yield about | {"kind": "gain"} | _gain_cells(one.gain), marks
        for before, row in enumerate(one.moved, 1):
            counts = {f"answer_{i}": count for i, count in enumerate(row, 1)}
            yield about | {"kind": "moved", "round": before, "students": sum(row)} | counts, marks
    if questions:
        yield {"kind": "gain"} | _gain_cells(whole(questions)), marks


def _gain_cells(gain: Gain) -> dict[str, object]:
    normalised = "" if gain.normalised is None else round(gain.normalised, 3)
    return {"students": gain.students, "before": gain.before, "after": gain.after, "gain": normalised}


def _answer(report: HandIn, question: QuestionId, number: int) -> object:
    """Return the answer of a report in a round, from 1; "" for none."""
    answers = report.answers.get(question, ())
    answer = answers[number - 1] if number <= len(answers) else None
    return "" if answer is None else answer + 1


def _tried(question: QuestionId, summary: ClassSummary, done: Sequence[dict[QuestionId, StepProgress]]) -> bool:
    return question in summary.passed or any(question in steps and steps[question].attempts for steps in done)
