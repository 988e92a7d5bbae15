"""What the panel of lessons says: the walkthrough's view as HTML, one block for each part of a step."""

import html
from typing import Final

from app.i18n.speaking import tr
from app.lessons.curve_drawing import DrawingVerdict, drawing_svg
from app.lessons.labels import sentence
from app.lessons.outcomes import Attempt
from app.lessons.phases import Phase
from app.lessons.step_view import StepView
from app.page.lessons.search_plot import search_plot
from app.text.lesson_text import inline_html, lesson_html, plain

PHASES: Final[dict[str, str]] = {
    "predict": "Predict",
    "do": "Do",
    "observe": "Observe",
    "explain": "Explain",
    "challenge": "Challenge",
}
"""What a person calls the parts of a step."""

NEXT: Final = {name: f"Next: {shown.lower()}" for name, shown in PHASES.items()}
"""What stands on the button that goes on to a part."""

BLOCKS: Final = ("list", "head", "text", "drawing", "choices", "live", "verdict", "after", "attempt", "learned", "hints")
"""All blocks."""


def blocks_html(view: StepView, live: tuple[tuple[str, str], ...], computing: bool, operated: bool) -> dict[str, str]:
    """Return every block's HTML, "" for one that has nothing to say.

    Args:
        view: of the walkthrough.
        live: label and value of the numbers in view.
        computing: whether further runs are still being made.
        operated: whether the reader has buttons for the answers; otherwise they are listed.
    """
    texts = dict(view.texts)
    folder = view.step.setup.folder
    main = texts.get(view.phase.value, "")
    after = ""
    if view.phase is Phase.OBSERVE:
        main, after = "", texts.get("observe", "")
    made = {
        "head": head_html(view),
        "text": lesson_html(main, folder),
        "drawing": "" if operated or view.phase is not Phase.PREDICT else figure_html(view),
        "choices": "" if operated else _choices_html(view),
        "live": "".join(f"<div><b>{html.escape(value)}</b><span>{html.escape(label)}</span></div>" for label, value in live),
        "verdict": verdict_html(view, computing),
        "after": lesson_html(after, folder) if after else "",
        "attempt": attempt_html(view),
        "learned": learned_html(view),
        "hints": "".join(f"<li>{inline_html(hint)}</li>" for hint in view.hints),
    }
    if made["hints"]:
        made["hints"] = f"<h3>{tr('Hints')}</h3><ol>{made['hints']}</ol>"
    # Formulas that explain have the numbers of this moment.
    kind = {"text": " duet-l-explain"} if view.phase is Phase.EXPLAIN else {}
    return {
        name: f'<div class="duet duet-lesson duet-l-{name}{kind.get(name, "")}">{made[name]}</div>' if made[name] else ""
        for name in made
    }


def head_html(view: StepView) -> str:
    """Return title, goal, and where in the step one is."""
    lesson, step = view.lesson, view.step
    here = view.phases.index(view.phase)
    parts = "".join(
        f'<li class="{"now" if i == here else "done" if i < here else ""}"{" aria-current=step" if i == here else ""}>'
        f"{tr(PHASES[phase.value])}</li>"
        for i, phase in enumerate(view.phases)
    )
    source = f" · {tr('eq.')} {html.escape(lesson.equations)}" if lesson.equations else ""
    where = tr("Lesson {lesson} · step {step} of {count}", lesson=lesson.number, step=view.index + 1, count=view.count)
    intro = f'<p class="lesson-title">{inline_html(lesson.title)}</p>'
    if view.index == 0:
        intro += f'<div class="intro">{lesson_html(lesson.goal, step.setup.folder)}</div>'
    return (
        f'<p class="crumb">{where}{source}</p>{intro}'
        f"<h2>{inline_html(step.title)}</h2>"
        f'<div class="goal"><b>{tr("Goal")}</b> {lesson_html(step.goal, step.setup.folder)}</div>'
        f'<ol class="phases">{parts}</ol>'
    )


def _choices_html(view: StepView) -> str:
    if view.phase not in (Phase.PREDICT, Phase.DO) or not view.choices:
        return ""
    return "<ol>" + "".join(f"<li>{inline_html(choice)}</li>" for choice in view.choices) + "</ol>"


def verdict_html(view: StepView, computing: bool) -> str:
    """Return the answer beside what was measured, and the reason; while the run goes on, what was predicted."""
    if computing:
        return f'<p class="wait duet-say">{tr("Measuring the runs that this one is compared with …")}</p>'
    if view.phase in (Phase.PREDICT, Phase.DO):
        said = f" <b>{inline_html(view.choices[view.chosen])}</b>" if view.chosen is not None else ""
        drawn = figure_html(view) if view.phase is Phase.DO and view.drawing is not None and view.drawing.drawn else ""
        return f'<p class="mine">{tr("Your prediction:")}{said}</p>{drawn}' if said or drawn else ""
    if view.phase is not Phase.OBSERVE and not view.showing:
        return ""
    if view.contrast is not None:
        here, asked = html.escape(view.contrast.here), html.escape(view.contrast.asked)
        return (
            f'<div class="card why duet-say"><b>{html.escape(view.contrast.headline)}</b>{_lines(view.why_outcome)}'
            f'<ul class="runs"><li><i></i>{tr("this run: {what}", what=here)}</li>'
            f'<li><i class="dash"></i>{tr("the question’s run, dashed and translucent: {what}", what=asked)}</li></ul></div>'
            + (_reply(view) if view.why_outcome else "")
        )
    # A screen reader is read the card, not the numbers of the axes.
    figure = figure_html(view) if view.drawing is not None and view.drawing.truth else ""
    near = drawing_verdict_html(view.drawing.verdict) if view.drawing is not None else ""
    if view.verdict is None:
        measured = f"<b>{tr('Measured in this run')}</b>{_lines(view.outcome)}"
        return f'{figure}<div class="card duet-say">{near}{measured}</div>' if view.outcome else ""
    verdict = view.verdict
    mine = view.choices[view.chosen] if view.chosen is not None else ""
    mark = "✓" if verdict.right else "↺"
    reason = f"<dt>{tr('Because')}</dt><dd>{html.escape(view.because)}</dd>" if view.because else ""
    return (
        f'{figure}<div class="card {"right" if verdict.right else "wrong"} duet-say">{near}<p class="mark"><span>{mark}</span> '
        f"<b>{html.escape(verdict.headline)}</b></p>"
        f"<dl><dt>{tr('You said')}</dt><dd>{inline_html(mine)}</dd>{reason}<dt>{tr('Measured')}</dt><dd>{_lines(verdict.lines)}</dd></dl>"
        f"{_reply(view)}</div>"
    )


def figure_html(view: StepView) -> str:
    """Return the student's curve, beside the truth once the outcome is known; "" where no curve is asked for."""
    drawing, curves = view.step.drawing, view.drawing
    if drawing is None or curves is None:
        return ""
    return f'<figure class="duet duet-curves">{drawing_svg(drawing, curves.drawn, curves.truth)}</figure>'


def drawing_verdict_html(verdict: DrawingVerdict | None) -> str:
    """Return how near the student's curve came; "" for no curve."""
    if verdict is None:
        return ""
    mark = "✓ " if verdict.right else "↺ " if verdict.right is not None else ""
    return f'<p class="mark"><span>{mark}</span><b>{html.escape(verdict.text)}</b></p>'


def _reply(view: StepView) -> str:
    return lesson_html(view.verdict.reply, view.step.setup.folder) if view.verdict is not None else ""


def _lines(lines: tuple[str, ...]) -> str:
    return "".join(f"<p>{html.escape(line)}</p>" for line in lines)


def attempt_html(view: StepView) -> str:
    """Return how the newest attempt at the challenge went: every inequality, the missed ones first."""
    if view.phase is not Phase.CHALLENGE:
        return ""
    passed = f'<p class="mark"><span>★</span> <b>{tr("Challenge passed.")}</b></p>' if view.passed else ""
    if view.attempt is None:
        return f'<div class="card right">{passed}</div>' if passed else ""
    attempt = view.attempt
    headline = tr("Passed.") if attempt.passed else tr("Not yet.")
    counted = " " + tr("Attempt {number}.", number=view.attempts) if view.attempts > 1 else ""
    kind = "right" if attempt.passed else "wrong"
    return f'<div class="card {kind} duet-say"><p><b>{headline}</b>{counted}</p>{_judgements(attempt)}</div>{_search(view)}'


def _search(view: StepView) -> str:
    challenge = view.step.challenge
    return "" if challenge is None or not view.tries else search_plot(challenge, view.tries, view.lesson.language)


def learned_html(view: StepView) -> str:
    """Return what was learned in the lesson, once its last step is finished."""
    if not view.lesson_finished or not view.lesson.learned:
        return ""
    learned = lesson_html(view.lesson.learned, view.step.setup.folder)
    return f'<div class="card learned duet-say"><b>{tr("What you learned")}</b>{learned}</div>'


def _judgements(attempt: Attempt) -> str:
    note = f"<p>{html.escape(tr(attempt.note))}</p>" if attempt.note else ""
    rows = "".join(
        f"<li class={'ok' if j.passed else 'no'}><span>{'✓' if j.passed else '✗'}</span>{html.escape(sentence(tr(j.text)))}</li>"
        for j in sorted(attempt.judgements, key=lambda j: j.passed)
        # The note says already why these have nothing to tell.
        if not attempt.note or j.passed or j.value is not None
    )
    return f"{note}<ul>{rows}</ul>"


def choice_label(number: int, text: str, chosen: bool) -> str:
    """Return what stands on the button of an answer; `number` from 1."""
    return f"{'● ' if chosen else ''}{number}   {plain(text)}"
