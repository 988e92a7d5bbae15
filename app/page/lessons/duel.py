"""A duel in a lesson, as HTML: the pushes that count and the nearest of them; and the record of a class."""

from markupsafe import Markup

from app.i18n.speaking import decimal
from app.lessons.step_view import StepView
from app.text.templates import macros

_TEMPLATE = "page/lessons/duel.html"


def duel_html(view: StepView) -> Markup:
    """Return the score of a step's duel; "" before the first push, and where there is none."""
    challenge = view.step.challenge
    if challenge is None or not challenge.best_of or not view.tries:
        return Markup()
    pushes = [_with_words(one.measured) for one in view.tries]
    nearest = pushes.index(min(pushes))
    return macros(_TEMPLATE).score(pushes, challenge.best_of, nearest)


def record_html(margin: float | None) -> Markup:
    """Return how near a class has come. `margin`: the smallest d less d_m [m]; None for nothing."""
    return Markup() if margin is None else macros(_TEMPLATE).record(*_with_words(margin))


def _with_words(margin: float) -> tuple[float, str]:
    """Return a margin [m], and its size as a person reads it."""
    return margin, decimal(f"{1000.0 * abs(margin):.1f} mm")
