"""The guess of d on the line of contact: what the card shows of it, and the box by which its script sends it."""

from collections.abc import Callable
from typing import Any

import viser

from app.i18n.speaking import tr
from app.lessons.distance_guess import asks_for_distance
from app.lessons.session.lesson_session import LessonSession
from app.page.lessons.lesson_panel import ORDER
from app.web.viser_internals import uuid_of

_PLACE = ORDER["choices"] + 0.5


class GuessBox:
    """A hidden box, in which `contact_guess.js` types a guess in mm. The caller has opened its container.

    Args:
        post: has something done on the thread to which the lessons belong; its second argument names the control.
        guess: takes the names of lesson and step, and the distance [m].

    Attributes:
        id: of the box on the page.
    """

    def __init__(
        self, gui: viser.GuiApi, post: Callable[[Callable[[], None], object], None], guess: Callable[[str, str, float], None]
    ) -> None:
        self._guess = guess
        box = gui.add_text("guess", "", order=_PLACE)
        self.id = uuid_of(box)
        hidden = f'div:has(> div > div > p > label[for="{self.id}"])'
        gui.add_html(f'<div class="duet-lesson-style"><style>{hidden}{{display:none}}</style></div>', order=_PLACE)

        @box.on_update
        async def _(event: viser.GuiEvent[Any]) -> None:
            if event.client_id is not None:
                text = str(event.target.value)[:200]
                post(lambda: self._take(text), "guess")

    def _take(self, text: str) -> None:
        try:
            place, mm = text.split(" ")
            lesson, step = place.split("/")
            distance = float(mm) / 1000.0
        except ValueError:
            # Not from our script.
            return
        self._guess(lesson, step, distance)


def guess_words(lessons: LessonSession, box: str) -> dict[str, object]:
    """Return what the card shows of a guess: its name, where it is [mm], the step, and the box, "" while no guess is taken; {} where the
    step asks for no distance, and where the reader operates nothing: in a class the guess on the stage is not the reader's.

    Args:
        box: id of the box on the reader's page, "" for one that operates nothing.
    """
    walk = lessons.walk
    if not box or not lessons.open or lessons.listing or not asks_for_distance(walk.step):
        return {}
    mm = None if walk.done.guess is None else round(1000.0 * walk.done.guess)
    return {
        "guess": {
            "name": tr("my guess"),
            "hint": tr("Drag ▼ along the axis: how far apart?"),
            "mm": mm,
            "at": f"{walk.lesson.id}/{walk.step.id}",
            "box": box if walk.guessing else "",
        }
    }
