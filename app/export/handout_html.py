"""A lesson on paper: questions, answers to tick, axes to draw on and room to write; the teacher's copy says what comes out."""

import html
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Final

from app.export.report_html import locked_page, lowered
from app.i18n.speaking import tr
from app.lessons.curve_drawing import axes_text, board_svg, drawing_svg
from app.lessons.labels import label_of, sentence
from app.lessons.lesson import Lesson, Step
from app.lessons.notes import Notes, read_notes
from app.lessons.outcomes import StepOutcome, reference
from app.lessons.step_view import fill
from app.lessons.texts import without_outcome
from app.text.lesson_text import inline_html, lesson_html, plain
from app.text.picture import PICTURE

RULES: Final = 3
"""Lines to write a reason on."""


def handout_html(lesson: Lesson, notes: str | None = None) -> str:
    """Return a lesson as a page to print, in the current language; it loads and runs nothing.

    Args:
        lesson: with the texts of that language.
        notes: the teacher's, as Markdown; None for the student's copy, which holds nothing that a run has yet to show.
    """
    read = None if notes is None else read_notes(notes)
    title = tr("Lesson {number}: {title}", number=lesson.number, title=plain(lesson.title))
    copy = f"{tr('Name')}: {'_' * 24}" if read is None else tr("Teacher's copy")
    about = (copy, f"{lesson.minutes} min", *((f"({lesson.equations})",) if lesson.equations else ()))
    folder = lesson.steps[0].setup.folder
    parts = [
        f'<h1>{html.escape(title)}</h1><p class="about">{html.escape(" · ".join(about))}</p>',
        f'<div class="text">{lesson_html(lesson.goal)}</div>',
        *(_notes(read.text, folder) if read is not None else ()),
        *("".join(_step(lesson, i, read)) for i in range(len(lesson.steps))),
        *(_afterwards(lesson) if read is None else ()),
    ]
    return locked_page(title, ("handout.css",), parts)


def _step(lesson: Lesson, index: int, notes: Notes | None) -> Iterator[str]:
    step, teacher = lesson.steps[index], notes is not None
    outcome = replace(reference(step, step.setup), reference=False) if teacher else None

    def text(source: str) -> str:
        return _text(source, step, outcome, lesson)

    yield f"<section><h2>{lesson.number}.{index + 1}&ensp;{inline_html(step.title)}</h2>{_part('goal', tr('Goal'), text(step.goal))}"
    if step.question is not None:
        yield _part("question", tr("Question"), text(step.question.text))
    if step.drawing is not None:
        chart = board_svg(step.drawing, ()) if outcome is None else drawing_svg(step.drawing, (), outcome.curve)
        caption = html.escape(sentence(axes_text(step.drawing)))
        yield f'<figure class="axes block"><figcaption>{caption}</figcaption>{chart}</figure>'
    yield from _answers(step, outcome, lesson)
    if step.question is not None and not teacher:
        yield _ruled(tr("My reason"))
    yield _part("do", tr("Do"), text(step.do))
    if step.measurements:
        yield _measured(step, outcome, lesson)
    if teacher:
        for name, source in ((tr("Observe"), step.observe), (tr("Explain"), step.explain)):
            if source:
                yield _part("after", name, text(source))
    if step.challenge is not None and (teacher or step.question is None):
        yield from _challenge(step, outcome, lesson)
    if teacher and step.hints:
        items = "".join(f"<li>{inline_html(hint)}</li>" for hint in step.hints)
        yield _part("hints", tr("Hints"), f"<ol>{items}</ol>")
    if notes is not None:
        for own in notes.steps:
            if own.number == index + 1:
                yield from _notes(own.text, step.setup.folder)
    yield "</section>"


def _text(source: str, step: Step, outcome: StepOutcome | None, lesson: Lesson) -> str:
    """Return a text of a step as HTML; without an outcome, with blanks for what would give the answer away."""
    shown = without_outcome(source, step) if outcome is None else source
    return lesson_html(fill(step, shown, outcome, lesson.language), step.setup.folder)


def _challenge(step: Step, outcome: StepOutcome | None, lesson: Lesson, name: str = "") -> Iterator[str]:
    """Yield the challenge of a step; without an outcome, with room to write. `name`: of the step, where it stands elsewhere."""
    assert step.challenge is not None
    yield _part("challenge", f"{tr('Challenge')} {name}".strip(), _text(step.challenge.text, step, outcome, lesson))
    if outcome is None:
        yield _ruled(tr("What I set, and what came out"))


def _answers(step: Step, outcome: StepOutcome | None, lesson: Lesson) -> Iterator[str]:
    """Yield the answers to tick; with an outcome, the right one is ticked and the reply to each stands below it."""
    if step.question is None:
        return
    yield '<ol class="answers">'
    for i, choice in enumerate(step.question.choices):
        answer = inline_html(fill(step, choice.text, outcome, lesson.language))
        if outcome is None:
            yield f'<li class="block"><span class="box"></span><div>{answer}</div></li>'
            continue
        right = i == step.question.right
        reply = lesson_html(fill(step, choice.reply, outcome, lesson.language), step.setup.folder)
        mark = f'<b class="mark">✓ {html.escape(tr("right"))}</b> ' if right else ""
        kind, tick = (" right", "✓") if right else ("", "")
        yield f'<li class="block{kind}"><span class="box">{tick}</span><div>{mark}{answer}<div class="reply">{reply}</div></div></li>'
    yield "</ol>"


def _measured(step: Step, outcome: StepOutcome | None, lesson: Lesson) -> str:
    """Return what was measured; without an outcome the names alone, and room for the numbers."""
    if outcome is not None:
        lines = "".join(f"<li>{lowered(html.escape(line))}</li>" for line in outcome.lines(step, lesson.language))
    else:
        names = (lowered(html.escape(label_of(m, lesson.language))) for m in step.measurements)
        lines = "".join(f'<li class="blank"><span>{name}:</span><i></i></li>' for name in names)
    return _part("measured", tr("Measured"), f"<ul>{lines}</ul>")


def _part(kind: str, name: str, content: str) -> str:
    return f'<div class="part {kind}"><h3>{html.escape(name)}</h3><div class="text">{content}</div></div>'


def _ruled(name: str) -> str:
    return f'<div class="ruled block"><h3>{html.escape(name)}</h3>{"<i></i>" * RULES}</div>'


def _notes(text: str, folder: Path) -> tuple[str, ...]:
    """Return the teacher's notes, which are in English, as a frame of their own."""
    if not text:
        return ()
    name = html.escape(tr("Teacher's notes"))
    return (f'<aside lang="en"><h3>{name}</h3><div class="text">{lesson_html(text, folder)}</div></aside>',)


def _afterwards(lesson: Lesson) -> tuple[str, ...]:
    """Return what is read when the outcome is known, as pages of their own: challenges after a question, and the pictures that explain."""
    made: list[str] = []
    for i, step in enumerate(lesson.steps):
        if step.question is not None and step.challenge is not None:
            made += _challenge(step, None, lesson, f"{lesson.number}.{i + 1}")
        for found in PICTURE.finditer("\n".join((step.goal, step.do, step.observe, step.explain))):
            picture = lesson_html(found[0].strip(), step.setup.folder)
            made.append(
                f'<figure class="picture-of-lesson block">{picture}<figcaption>{html.escape(found[1])}</figcaption></figure>'
            )
    if not made:
        return ()
    return (f'<section class="afterwards"><h2>{html.escape(tr("For afterwards"))}</h2>{"".join(made)}</section>',)
