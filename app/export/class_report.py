"""What a class leaves behind as one HTML page that prints well: the questions with their counts, the challenges, the reports handed in."""

import html
import time
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import replace

from app.export.class_summary import AskedQuestion, ClassSummary, HandIn
from app.export.lab_report import Done, rich_html, step_entry
from app.export.report_html import entry_html, locked_page, lowered
from app.export.tally_html import bars_html, cloud_html, switches_text, tie_text
from app.i18n.speaking import set_language, tr
from app.lessons.lesson import Lesson
from app.lessons.outcomes import reference
from app.lessons.phases import fitting
from app.lessons.progress import from_json
from app.lessons.step_view import fill
from app.lessons.tally import QuestionId
from app.recording.provenance import made_here
from app.settings import Language
from app.text.html_element import element
from app.text.lesson_text import inline_html, plain
from scenes.rerun import Stopped, never


def class_report_bytes(
    summary: ClassSummary, lessons: Sequence[Lesson], language: Language, stopped: Callable[[], bool] = never
) -> bytes:
    """Return the report as one HTML file, in which everything that students wrote is escaped.

    Args:
        lessons: in the language of the report.
        stopped: asked now and then; when it says True, everything ends with `Stopped`.
    """
    set_language(language)
    title = tr("Class report")
    parts = [element("h1", title), element("p", " · ".join(_about(summary)), class_="about"), _overview(summary, lessons)]
    for section in (_questions(summary, lessons), _reports(summary, lessons)):
        for part in section:
            if stopped():
                raise Stopped
            parts.append(part)
    return locked_page(title, ("report.css", "class_report.css"), parts).encode()


def _about(summary: ClassSummary) -> Iterator[str]:
    yield time.strftime("%Y-%m-%d", time.localtime(summary.saved))
    yield tr("students who answered: {count}", count=summary.students)
    yield tr("reports handed in: {count}", count=len(summary.hand_ins))
    yield f"{tr('Made by Duet')} {made_here()['duet']}"


def _overview(summary: ClassSummary, lessons: Sequence[Lesson]) -> str:
    """Return the table of all steps that were asked about, or have a challenge that was passed."""
    asked = summary.asked_in(lessons)
    names = "", tr("answered"), tr("right, first time"), tr("right, last time"), tr("passed the challenge")
    rows: list[str] = []
    for lesson, index in _steps(lessons, {*asked, *summary.passed}):
        step = lesson.steps[index]
        question = lesson.id, step.id
        cells = [element("td", "", f"{lesson.number}.{index + 1}&ensp;{inline_html(step.title)}")]
        one, right = asked.get(question), None if step.question is None else step.question.right
        if one is None or right is None:
            cells += [element("td")] * 3
        else:
            first, last = one.rounds[0], one.rounds[-1]
            shares = [f"{tally.share(right)} %" if any(tally.counts) else "" for tally in (first, last)]
            cells += [element("td", text) for text in (str(last.answered), shares[0], shares[1] if len(one.rounds) > 1 else "")]
        cells.append(element("td", "" if step.challenge is None else str(summary.passed.get(question, 0))))
        rows.append(element("tr", "", *cells))
    if not rows:
        return ""
    head = element("thead", "", element("tr", "", *(element("th", name) for name in names)))
    return element("table", "", head, element("tbody", "", *rows), class_="overview")


def _questions(summary: ClassSummary, lessons: Sequence[Lesson]) -> Iterator[str]:
    asked = summary.asked_in(lessons)
    before: Lesson | None = None
    for lesson, index in _steps(lessons, asked):
        if lesson is not before:
            yield _chapter(lesson)
        before = lesson
        yield _question(lesson, index, asked[lesson.id, lesson.steps[index].id])


def _chapter(lesson: Lesson) -> str:
    title = tr("Lesson {number}: {title}", number=lesson.number, title=plain(lesson.title))
    return element("h2", title, class_="chapter")


def _question(lesson: Lesson, index: int, asked: AskedQuestion) -> str:
    step = lesson.steps[index]
    assert step.question is not None
    outcome = replace(reference(step, step.setup), reference=False)
    rounds = list(enumerate(asked.rounds, 1))
    shown = [rounds[0], rounds[-1]] if len(rounds) > 1 else rounds
    choices = [fill(step, choice.text, outcome, lesson.language) for choice in step.question.choices]
    words = (tie_text(asked.rounds[-1]), switches_text(asked.switches, step.question.right))
    counts = [tr("Round {number}: {count} answered", number=number, count=tally.answered) for number, tally in rounds]
    measured = [element("li", "", lowered(html.escape(line))) for line in outcome.lines(step, lesson.language)]
    return element(
        "article",
        "",
        element("h3", "", f"{lesson.number}.{index + 1}&ensp;{inline_html(step.title)}"),
        element("div", "", rich_html(fill(step, step.question.text, None, lesson.language)), class_="question"),
        element(
            "div",
            "",
            element("p", " · ".join(counts), class_="about"),
            bars_html(choices, shown, step.question.right),
            *(element("p", text) for text in words if text),
            cloud_html(step.drawing, shown, outcome.curve),
            class_="duet-poll",
        ),
        element("dl", "", element("dt", tr("Measured")), element("dd", "", element("ul", "", *measured))) if measured else "",
    )


def _reports(summary: ClassSummary, lessons: Sequence[Lesson]) -> Iterator[str]:
    if summary.hand_ins:
        yield element("h2", tr("Reports handed in"), class_="reports")
    for one, name in zip(summary.hand_ins, report_names(summary.hand_ins), strict=True):
        yield element("section", "", element("h2", name), *_report(one, lessons), class_="report")


def _report(report: HandIn, lessons: Sequence[Lesson]) -> Iterator[str]:
    steps = from_json(report.progress).steps
    before: Lesson | None = None
    for lesson, index in _steps(lessons, steps):
        if lesson is not before:
            yield element("h3", tr("Lesson {number}: {title}", number=lesson.number, title=plain(lesson.title)), class_="chapter")
        before, step = lesson, lesson.steps[index]
        yield entry_html(step_entry(Done(lesson, index, fitting(step, steps[lesson.id, step.id]))), rich_html)


def report_names(reports: Sequence[HandIn]) -> list[str]:
    """Return what each report is called, each name once: those without one, and those that are there already, have a number."""
    names: list[str] = []
    for report in reports:
        base = report.name or tr("without a name")
        name, number = (base, 1) if report.name else (f"{base} 1", 1)
        while name in names:
            number += 1
            name = f"{base} ({number})" if report.name else f"{base} {number}"
        names.append(name)
    return names


def _steps(lessons: Sequence[Lesson], wanted: Collection[QuestionId]) -> Iterator[tuple[Lesson, int]]:
    """Yield lesson and index of the wanted steps, in the order of the lessons."""
    for lesson in lessons:
        for index, step in enumerate(lesson.steps):
            if (lesson.id, step.id) in wanted:
                yield lesson, index
