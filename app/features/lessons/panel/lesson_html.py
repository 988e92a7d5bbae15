"""A step's view as HTML, in blocks."""

from typing import Final

from markupsafe import Markup

from app.features.lessons.bookmark import Phase
from app.features.lessons.curve_drawing import drawing_svg
from app.features.lessons.labels import sentence
from app.features.lessons.panel.lesson_charts import search_plot
from app.features.lessons.step_view import StepView, first_sentence
from app.features.lessons.texts import told_in
from app.i18n.speaking import N_, decimal, tr
from app.text.lesson_text import lesson_html, plain
from app.text.templates import macros

PHASES: Final[dict[str, str]] = {
    "predict": N_("Predict"),
    "do": N_("Do"),
    "observe": N_("Observe"),
    "explain": N_("Explain"),
    "challenge": N_("Challenge"),
}

NEXT: Final = {
    "predict": N_("Next: predict"),
    "do": N_("Next: do"),
    "observe": N_("Next: observe"),
    "explain": N_("Next: explain"),
    "challenge": N_("Next: challenge"),
}

BLOCKS: Final = (
    "list",
    "head",
    "text",
    "drawing",
    "choices",
    "live",
    "said",
    "verdict",
    "after",
    "attempt",
    "learned",
    "hints",
)

_NOTHING: Final = Markup()
_TEMPLATE: Final = "features/lessons/panel/lesson.html"
_DUEL: Final = "features/lessons/panel/duel.html"


def blocks_html(
    view: StepView, live: tuple[tuple[str, str], ...], computing: bool, operated: bool
) -> dict[str, Markup]:
    made, texts, folder = macros(_TEMPLATE), dict(view.texts), view.step.setup.folder
    observing, asking = view.phase is Phase.OBSERVE, view.phase in (Phase.PREDICT, Phase.DO)
    verdict = _verdict_html(view, computing)
    waits = computing or asking
    blocks = {
        "head": made.head(view, [tr(PHASES[phase.value]) for phase in view.phases]),
        "text": lesson_html("" if observing else texts.get(view.phase.value, ""), folder),
        "drawing": figure_html(view) if view.phase is Phase.PREDICT and not operated else _NOTHING,
        "choices": made.choices(view.choices) if view.choices and asking and not operated else _NOTHING,
        # Measured values are told once: in the verdict.
        "live": _NOTHING if observing else made.live(live),
        "said": verdict if waits else _NOTHING,
        "verdict": _NOTHING if waits else verdict,
        # Its numbers belong to the question's run.
        "after": _after_html(view) if observing and not view.showing else _NOTHING,
        "attempt": attempt_html(view),
        "learned": learned_html(view),
        "hints": made.hints(view.hints) if view.hints else _NOTHING,
    }
    # Explaining formulas show the current numbers.
    return {
        name: made.block(name, block, name == "text" and view.phase is Phase.EXPLAIN) if block else block
        for name, block in blocks.items()
    }


def _verdict_html(view: StepView, computing: bool) -> Markup:
    made, curves = macros(_TEMPLATE), view.drawing
    chosen = None if view.done.choice is None else view.choices[view.done.choice]
    if computing:
        return made.measuring()
    if view.phase in (Phase.PREDICT, Phase.DO):
        if view.step.concept:
            return _NOTHING
        figure = figure_html(view) if view.phase is Phase.DO and curves is not None and curves.drawn else ""
        return made.prediction(chosen, figure) if chosen is not None or figure else _NOTHING
    if view.phase is not Phase.OBSERVE and not view.showing:
        return _NOTHING
    folder = view.step.setup.folder
    reply = lesson_html(view.verdict.reply, folder) if view.verdict is not None else _NOTHING
    if view.contrast is not None:
        return made.contrast(view.contrast, view.why_outcome) + (reply if view.why_outcome else "")
    # A screen reader reads the card, not the numbers of the axes.
    figure = figure_html(view) if curves is not None and curves.truth else _NOTHING
    near = made.drawn(None if curves is None else curves.verdict)
    if view.verdict is not None:
        sentence = lesson_html(first_sentence(view.verdict.reply), folder)
        shown = chosen or "", _number(view), sentence, view.done.because
        return made.card(view.verdict, near, tr("You said"), *shown) + figure
    return figure + made.measured(near, view.outcome) if view.outcome else _NOTHING


def _number(view: StepView) -> tuple[str, ...]:
    question, choice, measured = view.step.question, view.done.choice, view.step.measurements
    if question is None or choice is None or not measured:
        return ()
    told = told_in(view.step, first_sentence(question.choices[choice].reply))
    return () if measured[0].id in told else view.outcome[:1]


def _after_html(view: StepView) -> Markup:
    folder = view.step.setup.folder
    observed = lesson_html(dict(view.texts).get("observe", ""), folder)
    if view.verdict is None:
        return observed
    rest = " ".join(view.verdict.reply.split()).removeprefix(first_sentence(view.verdict.reply)).strip()
    number = _number(view)
    lines = [line for line in view.verdict.lines if line not in number]
    if not (rest or lines or observed):
        return _NOTHING
    return macros(_TEMPLATE).more(lines, lesson_html(rest, folder), observed)


def figure_html(view: StepView) -> Markup:
    drawing, curves = view.step.drawing, view.drawing
    if drawing is None or curves is None:
        return _NOTHING
    return macros(_TEMPLATE).figure(drawing_svg(drawing, curves.drawn, curves.truth))


def attempt_html(view: StepView) -> Markup:
    made, attempt, challenge = macros(_TEMPLATE), view.done.last, view.step.challenge
    if view.phase is not Phase.CHALLENGE:
        return _NOTHING
    if attempt is None:
        return made.passed_before() if view.done.passed else _NOTHING
    judgements = [
        (j.passed, sentence(tr(j.text)))
        for j in sorted(attempt.judgements, key=lambda j: j.passed)
        # The note already explains why these have no value.
        if not attempt.note or j.passed or j.value is not None
    ]
    # A duel counts its pushes, not other attempts.
    attempts = 0 if challenge is not None and challenge.best_of else view.done.attempts
    card = duel_html(view) + made.attempt(attempt, attempts, judgements, view.stale)
    if challenge is not None and challenge.search and view.tries:
        card += search_plot(challenge, view.tries, view.lesson.language)
    return card


def duel_html(view: StepView) -> Markup:
    challenge = view.step.challenge
    if challenge is None or not challenge.best_of or not view.tries:
        return Markup()
    pushes = [_with_words(one.measured) for one in view.tries]
    nearest = pushes.index(min(pushes))
    return macros(_DUEL).score(pushes, challenge.best_of, nearest)


def record_html(margin: float | None) -> Markup:
    """Best margin of a class, the smallest d − d_m [m]; None before the first."""
    return Markup() if margin is None else macros(_DUEL).record(*_with_words(margin))


def _with_words(margin: float) -> tuple[float, str]:
    return margin, decimal(f"{1000.0 * abs(margin):.1f} mm")


def learned_html(view: StepView) -> Markup:
    if not view.lesson_finished or not view.lesson.learned:
        return _NOTHING
    return macros(_TEMPLATE).learned(lesson_html(view.lesson.learned, view.step.setup.folder))


def rules_html(css: str) -> Markup:
    return macros(_TEMPLATE).rules(Markup(css))


def choice_label(number: int, text: str, chosen: bool) -> str:
    return f"{'● ' if chosen else ''}{number}   {plain(text)}"
