"""A class's report as HTML, ZIP or CSV."""

import io
import re
import time
import zipfile
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from markupsafe import Markup

from app.features.classroom.class_summary import AskedQuestion, ClassSummary, HandIn
from app.features.classroom.tally_html import cloud_html, drawn_too, switches_text, tie_text
from app.features.handout.handout_html import PaperStep, told
from app.features.lab_report.gain import Gain, gains, whole
from app.features.lab_report.lab_report import (
    Done,
    ReportEntry,
    lesson_title,
    report_html,
    rich_html,
    step_entry,
)
from app.features.lab_report.report_html import SHEET, locked_page, plain_svg
from app.features.lessons.bookmark import fitting
from app.features.lessons.lesson import MOST_CHOICES, Lesson, Step
from app.features.lessons.progress import StepProgress, from_json
from app.features.lessons.tally import QuestionId, Tally
from app.i18n.speaking import set_language, tr
from app.recording.run_file import made_here
from app.settings import Language
from scenes.files import csv_text
from scenes.wanted import while_wanted


def class_report_bytes(summary: ClassSummary, lessons: Sequence[Lesson], language: Language) -> bytes:
    """Report as one HTML file; students' texts are escaped. `lessons`: in the report's language."""
    set_language(language)
    learned, asked = gains(summary.paired, lessons), summary.asked_in(lessons)
    steps = while_wanted(_steps(lessons, asked))
    return locked_page(
        "features/classroom/class_report.html",
        tr("Class report"),
        (SHEET, Path(__file__).with_name("class_report.css")),
        about=(
            time.strftime("%Y-%m-%d", time.localtime(summary.saved)),
            tr("students who answered: {count}", count=summary.students),
            tr("reports handed in: {count}", count=len(summary.hand_ins)),
            f"{tr('Made by Duet')} {made_here()['duet']}",
        ),
        names=report_names(summary.hand_ins),
        grid=list(_grid(summary, lessons)),
        overview=list(_overview(summary, lessons)),
        gains=learned,
        total=whole(learned),
        questions=(
            _Question(lesson, index, told(step), asked[lesson.id, step.id]) for lesson, index, step in steps
        ),
        reports=_reports(summary, lessons),
        lesson_title=lesson_title,
        rich=rich_html,
        svg=plain_svg,
    ).encode()


def _grid(summary: ClassSummary, lessons: Sequence[Lesson]) -> Iterator[tuple[Lesson, int, list[str]]]:
    """Marks of hand-ins: ✓ or ✗ for the prediction, ★ for a passed challenge, · for other work."""
    done = [from_json(one.progress).steps for one in summary.hand_ins]
    for lesson, index, step in _steps(_untested(lessons), {step for steps in done for step in steps}):
        marks: list[str] = []
        for steps in done:
            own = fitting(step, steps.get((lesson.id, step.id), StepProgress()))
            right = None if step.question is None or own.choice is None else own.choice == step.question.right
            said = "" if right is None else "✓" if right else "✗"
            marks.append(said + ("★" if own.passed else "") or ("" if own.untouched else "·"))
        yield lesson, index, marks


def _overview(
    summary: ClassSummary, lessons: Sequence[Lesson]
) -> Iterator[tuple[Lesson, int, tuple[str, ...]]]:
    """Number of answers, shares of right ones in the first and last round, and passes."""
    asked = summary.asked_in(lessons)
    for lesson, index, step in _steps(lessons, {*asked, *summary.passed}):
        question = lesson.id, step.id
        answered = ("", "", "")
        one, right = asked.get(question), None if step.question is None else step.question.right
        if one is not None and right is not None:
            first, last = one.rounds[0], one.rounds[-1]
            shares = [f"{tally.share(right)} %" if any(tally.counts) else "" for tally in (first, last)]
            said = [
                f"{tally.handed_in}{drawn_too(tally)}"
                for tally in ((first, last) if len(one.rounds) > 1 else (last,))
            ]
            answered = " → ".join(said), shares[0], shares[1] if len(one.rounds) > 1 else ""
        passed = "" if step.challenge is None else str(summary.passed.get(question, 0))
        yield lesson, index, (*answered, passed)


@dataclass(frozen=True)
class _Question(PaperStep):
    """A question with the class's answers."""

    asked: AskedQuestion

    @property
    def counts(self) -> list[str]:
        rounds = enumerate(self.asked.rounds, 1)
        return [
            tr("Round {number}: {count} answered", number=i, count=one.handed_in) + drawn_too(one)
            for i, one in rounds
        ]

    @property
    def rounds(self) -> list[tuple[int, Tally]]:
        rounds = list(enumerate(self.asked.rounds, 1))
        return [rounds[0], rounds[-1]] if len(rounds) > 1 else rounds

    @property
    def words(self) -> tuple[str, str]:
        right = None if self.step.question is None else self.step.question.right
        return tie_text(self.asked.rounds[-1]), switches_text(self.asked.switches, right)

    @property
    def cloud(self) -> Markup:
        return cloud_html(self.step.drawing, self.rounds, () if self.outcome is None else self.outcome.curve)


def _reports(summary: ClassSummary, lessons: Sequence[Lesson]) -> Iterator[tuple[str, list[ReportEntry]]]:
    named = zip(summary.hand_ins, report_names(summary.hand_ins), strict=True)
    for one, name in while_wanted(named):
        done = from_json(one.progress).steps
        found = _steps(_untested(lessons), done)
        yield (
            name,
            [
                step_entry(Done(lesson, i, fitting(step, done[lesson.id, step.id])))
                for lesson, i, step in found
            ],
        )


def class_zip_bytes(summary: ClassSummary, lessons: Sequence[Lesson], language: Language) -> bytes:
    """Lab reports without plots of runs, for `lwr-duet grade`."""
    set_language(language)
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for number, (name, entries) in enumerate(_reports(summary, lessons), 1):
            page = report_html(tr("Lab report"), entries, None, about=name)
            # The number separates names that differ only in characters forbidden in file names.
            plain_name = re.sub(r"[^\w ()-]", "_", name)
            archive.writestr(f"{number:03d} {plain_name}.html", page)
    return out.getvalue()


def report_names(reports: Sequence[HandIn]) -> list[str]:
    """Unique names; unnamed and repeated ones get a number."""
    names: list[str] = []
    for report in reports:
        base = report.name or tr("without a name")
        name, number = (base, 1) if report.name else (f"{base} 1", 1)
        while name in names:
            number += 1
            name = f"{base} ({number})" if report.name else f"{base} {number}"
        names.append(name)
    return names


def _untested(lessons: Sequence[Lesson]) -> list[Lesson]:
    return [lesson for lesson in lessons if not lesson.asked]


def _steps(lessons: Sequence[Lesson], wanted: Collection[QuestionId]) -> Iterator[tuple[Lesson, int, Step]]:
    for lesson in lessons:
        for index, step in enumerate(lesson.steps):
            if (lesson.id, step.id) in wanted:
                yield lesson, index, step


# ---- as a table: a row a question and round, a row a challenge, and a column a report ----------------

COLUMNS: Final = (
    *("lesson", "step", "kind", "round", "students", "drawn"),
    *(f"answer_{i + 1}" for i in range(MOST_CHOICES)),
    *("right_answer", "right", "passed", "before", "after", "gain"),
)


def class_table_bytes(summary: ClassSummary, lessons: Sequence[Lesson]) -> bytes:
    """CSV in UTF-8 with a byte order mark for spreadsheets; columns: see `class.md`."""
    set_language("en")
    found = (*_rows(summary, lessons), *_gain_rows(summary, lessons))
    rows = ([*(cells.get(column, "") for column in COLUMNS), *marks] for cells, marks in found)
    return csv_text([(*COLUMNS, *report_names(summary.hand_ins)), *rows], "\r\n").encode("utf-8-sig")


_Row = tuple[dict[str, object], list[object]]


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
                    cells = {
                        "kind": "question",
                        "round": number,
                        "students": tally.handed_in,
                        "drawn": len(tally.curves),
                    }
                    yield (
                        about | cells | counts | more,
                        [_answer(one, question, number) for one in summary.hand_ins],
                    )
            tried = question in summary.passed or any(
                question in steps and steps[question].attempts for steps in done
            )
            if step.challenge is not None and tried:
                marks: list[object] = [
                    int(steps[question].passed) if question in steps else "" for steps in done
                ]
                yield about | {"kind": "challenge", "passed": summary.passed.get(question, 0)}, marks


def _gain_rows(summary: ClassSummary, lessons: Sequence[Lesson]) -> Iterator[_Row]:
    questions, marks = gains(summary.paired, lessons), list[object]([""] * len(summary.hand_ins))
    for one in questions:
        about: dict[str, object] = {
            "lesson": one.lesson.id,
            "step": one.step.id,
            "right_answer": one.right + 1,
        }
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
    answers = report.answers.get(question, ())
    answer = answers[number - 1] if number <= len(answers) else None
    return "" if answer is None else answer + 1
