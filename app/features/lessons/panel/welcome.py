"""A newcomer's card."""

from collections.abc import Mapping

import viser

from app.features.lessons.session.lesson_actions import Enter
from app.features.lessons.session.lesson_session import LessonSession
from app.i18n.speaking import tr
from app.session.frame import Frame
from app.session.session import Session
from app.settings import LOOKS, STEP_KEYS, WHOLE, is_foreign
from app.text.templates import element, macros
from app.web.control_events import on_press
from app.web.viser_internals import uuid_of


def is_for_newcomers(query: Mapping[str, str]) -> bool:
    """True if a link asks for no lesson, and no settings except the look."""
    return all(key in LOOKS or (is_foreign(key) and key not in STEP_KEYS and key != WHOLE) for key in query)


class Welcome:
    """Shown by `welcome.js` once in a browser; any action ends it."""

    def __init__(self, gui: viser.GuiApi, session: Session, lessons: LessonSession) -> None:
        self._lessons, self._over = lessons, False
        self._buttons = [
            on_press(gui.add_button(tr("Start lesson 1")), lambda: session.post(Enter(lessons.book.first)))
        ]
        game = next((i for i, lesson in enumerate(lessons.book.lessons) if lesson.steps[0].at_lever), None)
        if game is not None:
            self._buttons.append(
                on_press(gui.add_button(tr("Be λ yourself")), lambda: session.post(Enter(game)))
            )
        self._card = gui.add_html(
            macros("features/lessons/panel/welcome.html").card(*map(uuid_of, self._buttons))
        )

    def show(self, frame: Frame) -> None:
        lessons = self._lessons
        if not self._over and (frame.live.held is not None or lessons.open or lessons.listing):
            self._over = True
            for button in self._buttons:
                button.visible = False
            self._card.content = element("div", class_="duet-welcome", data_over="1")
