"""What a newcomer reads first: what the silver arm has to do, and what to try."""

from collections.abc import Mapping

import viser

from app.i18n.speaking import tr
from app.lessons.session.lesson_session import LessonSession
from app.session.session import Session
from app.settings import FOREIGN_KEYS, LOOKS, STEP_KEYS, WHOLE
from app.web.viser_internals import uuid_of


def is_for_newcomers(query: Mapping[str, str]) -> bool:
    """Return whether a link asks for the page as it is at first: for no lesson, and for no settings but the look."""
    plain = FOREIGN_KEYS - STEP_KEYS - {WHOLE} | {*LOOKS}
    return all(key in plain or key.startswith("initialCamera") for key in query)


class Welcome:
    """The card; the script `welcome.js` shows it over the stage, once in a browser.

    Args:
        session, lessons: what the visitor does there ends it.
    """

    def __init__(self, gui: viser.GuiApi, session: Session, lessons: LessonSession) -> None:
        self._session, self._lessons, self._over = session, lessons, False
        self._start = gui.add_button(tr("Start lesson 1"))
        self._card = gui.add_html(_card_html(uuid_of(self._start)))

        @self._start.on_click
        async def _(_: viser.GuiEvent[viser.GuiButtonHandle]) -> None:
            session.post(lambda: lessons.enter(0), "lessons")

    def show(self) -> None:
        """End it as soon as the visitor moves something or opens the lessons."""
        lessons = self._lessons
        if not self._over and (self._session.held is not None or lessons.open or lessons.listing):
            self._over = True
            self._start.visible = False
            self._card.content = '<div class="duet-welcome" data-over="1"></div>'


def _card_html(start: str) -> str:
    lines = (
        tr('The <i class="silver">silver</i> arm must keep its hand in the ring,'),
        tr("and it must never touch you."),
        f"<b>{tr('Pull the <i>orange</i> arm into it.')}</b>",
    )
    text = "".join(f"<p>{line}</p>" for line in lines)
    return (
        f'<style>div:has(> [id="{start}"]),div:has(> .duet-welcome){{display:none}}</style>'
        f'<div class="duet-welcome" aria-label="{tr("Welcome")}"><div>{text}</div><div class="row">'
        f'<button type="button" class="first" data-duet-presses="{start}">{tr("Start lesson 1")}</button>'
        f'<button type="button">{tr("Just play")}</button></div></div>'
    )
