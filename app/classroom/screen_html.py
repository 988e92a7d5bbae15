"""HTML of the projector: the question, the class's answers, the outcome or the explanation over a dimmed scene; or a line below it."""

from collections.abc import Collection

from markupsafe import Markup

from app.classroom.ballots import Tally
from app.classroom.classroom import Poll
from app.classroom.classroom_html import poll_html
from app.classroom.presenter import Station, clock_text
from app.lessons.step_view import StepView
from app.text.templates import macros


def screen_html(station: Station, view: StepView | None, poll: Poll | None, left: int | None, cues: Collection[str]) -> Markup:
    """Return what lies over the scene on a projector; the script `presenter.js` shows it.

    Args:
        view: of the step; None while no lesson is open.
        poll: the question on the stage.
        left: seconds of the timer; None without one.
        cues: of the projector: `panels` beside the scene.
    """
    made, kinds = macros("classroom/screen.html"), " ".join((f"at-{station}", *cues))
    if view is None:
        return made.screen(f"scene {kinds}", "")
    if not station.is_scene:
        return made.screen(f"slide {kinds}", made.head(view) + _slide(station, view, poll) + _meter(poll, left))
    if "panels" in cues:
        return made.screen(f"scene {kinds}", "")
    texts = dict(view.texts)
    name = {Station.RUN: "do", Station.TRY: "challenge"}.get(station, "goal")
    counts = poll is not None and poll.open and (poll.tally.answered > 0 or left is not None)
    caption = made.caption(view, texts.get(name) or texts["goal"])
    return made.screen(f"scene {kinds}", caption + _meter(poll, left) if counts else caption)


def _slide(station: Station, view: StepView, poll: Poll | None) -> Markup:
    made, texts = macros("classroom/screen.html"), dict(view.texts)
    if station is Station.EXPLANATION:
        return made.slide(view, "", "", texts.get("explain", ""), "text")
    if station is Station.CHALLENGE:
        return made.slide(view, "", "", texts.get("challenge", ""), "text task")
    if poll is None:
        answers = made.outcome(view)
    else:
        seen = station is not Station.QUESTION and (poll.revealed or poll.outcome)
        answers = poll_html(poll if seen else _unseen(poll))
    after = texts.get("observe", "") if station is Station.OUTCOME else ""
    return made.slide(view, texts.get("predict", ""), answers, after, "text")


def _unseen(poll: Poll) -> Poll:
    """Return a poll without its answers: rows with empty bars, which grow at the reveal."""
    return Poll(poll.question, poll.choices, Tally((0,) * len(poll.choices), 0, 0), open=True, revealed=False)


def _meter(poll: Poll | None, left: int | None) -> Markup:
    """Return how many have answered, and the timer; "" where there is nothing to count."""
    if poll is None or not (poll.open or poll.revealed) or poll.outcome:
        return Markup()
    here = poll.tally.answered + poll.tally.waiting
    left = left if poll.open else None
    return macros("classroom/screen.html").meter(poll.tally, here, left, None if left is None else clock_text(left))
