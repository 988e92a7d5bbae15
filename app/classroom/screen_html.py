"""HTML of the projector: the question, the class's answers, the outcome or the explanation over a dimmed scene; or a line below it."""

from collections.abc import Collection

from app.classroom.ballots import Tally
from app.classroom.classroom import Poll
from app.classroom.classroom_html import poll_html
from app.classroom.presenter import Station, clock_text
from app.i18n.speaking import tr
from app.lessons.step_view import StepView
from app.text.html_element import element
from app.text.lesson_text import inline_html, lesson_html


def screen_html(station: Station, view: StepView | None, poll: Poll | None, left: int | None, cues: Collection[str]) -> str:
    """Return what lies over the scene on a projector; the script `presenter.js` shows it.

    Args:
        view: of the step; None while no lesson is open.
        poll: the question on the stage.
        left: seconds of the timer; None without one.
        cues: of the projector: `panels` beside the scene.
    """
    if view is None:
        body, kind = "", "scene"
    elif station.is_scene:
        counts = poll is not None and poll.open and (poll.tally.answered > 0 or left is not None)
        body, kind = ("" if "panels" in cues else _caption(station, view) + (_meter(poll, left) if counts else "")), "scene"
    else:
        body, kind = _head(view) + _slide(station, view, poll) + _meter(poll, left), "slide"
    shown = element("div", "", body, class_=" ".join((kind, f"at-{station}", *cues)))
    return element("div", "", shown, class_="duet-screen", hidden="")


def _head(view: StepView) -> str:
    where = tr("Lesson {lesson} · step {step} of {count}", lesson=view.lesson.number, step=view.index + 1, count=view.count)
    return element("header", "", element("span", where), element("b", "", inline_html(view.step.title)))


def _slide(station: Station, view: StepView, poll: Poll | None) -> str:
    folder, texts = view.step.setup.folder, dict(view.texts)
    if station is Station.EXPLANATION:
        return element("main", "", _text(lesson_html(texts.get("explain", ""), folder), "text"))
    if station is Station.CHALLENGE:
        return element("main", "", _text(lesson_html(texts.get("challenge", ""), folder), "text task"))
    question = _text(lesson_html(texts.get("predict", ""), folder), "question") if texts.get("predict") else ""
    if poll is None:
        answers = _text("".join(element("p", line) for line in view.outcome), "question")
    else:
        answers = poll_html(poll if poll.revealed or poll.outcome else _unseen(poll))
    after = _text(lesson_html(texts["observe"], folder), "text") if station is Station.OUTCOME and texts.get("observe") else ""
    return element("main", "", question, answers, after)


def _text(made: str, kind: str) -> str:
    return element("div", "", made, class_=f"{kind} duet duet-lesson") if made else ""


def _unseen(poll: Poll) -> Poll:
    """Return a poll without its answers: rows with empty bars, which grow at the reveal."""
    return Poll(poll.question, poll.choices, Tally((0,) * len(poll.choices), 0, 0), open=True, revealed=False)


def _caption(station: Station, view: StepView) -> str:
    texts = dict(view.texts)
    name = {Station.RUN: "do", Station.TRY: "challenge"}.get(station, "goal")
    text = lesson_html(texts.get(name) or texts["goal"], view.step.setup.folder)
    return element("div", "", element("b", "", inline_html(view.step.title)), _text(text, "text"), class_="caption")


def _meter(poll: Poll | None, left: int | None) -> str:
    """Return how many have answered, and the timer; "" where there is nothing to count."""
    if poll is None or not (poll.open or poll.revealed) or poll.outcome:
        return ""
    here = poll.tally.answered + poll.tally.waiting
    share = round(100.0 * poll.tally.answered / here) if here else 0
    count = tr("{count} of {here} answered", count=poll.tally.answered, here=here)
    bar = element("div", "", element("div", style=f"width:{share}%"), class_="share", aria_hidden="true")
    parts = [element("p", count, class_="count"), bar]
    if left is not None and poll.open:
        parts.append(_timer(left))
    return element("footer", "", *parts)


def _timer(left: int) -> str:
    if left > 0:
        return element("p", clock_text(left), class_="timer soon" if left <= 10 else "timer", role="timer")
    return element("p", tr("Time is up."), element("small", tr("Answers still count until the reveal.")), class_="timer up")
