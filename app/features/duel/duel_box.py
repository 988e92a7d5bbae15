"""Replay link and film of the nearest push."""

import viser

from app.features.exports.exports_panel import ExportsPanel
from app.features.lessons.panel.lesson_panel import ORDER
from app.features.lessons.panel.lesson_view import LessonView
from app.i18n.speaking import N_, set_language, spoken, tr
from app.page.panel_context import PanelContext
from app.page.panels import PagePanel
from app.page.panels.link_box import link_to
from app.session.actions import Action
from app.session.frame import Frame
from app.settings import PUSH, Language
from app.text.templates import element, macros
from app.web.control_events import on_press
from app.web.request import request_address
from controllers.errors import BadSetting
from scenes.inputs import Recorded
from scenes.run_text import run_text


class AskPushFilm(Action):
    """Make the film of the nearest push."""


def make_push_film(language: Language, push: Recorded) -> bytes:
    """Only the process that makes it imports what draws."""
    from app.features.duel.push_film import film_bytes

    set_language(language)
    return film_bytes(push)


class DuelBox(PagePanel):
    """Below the score in the lessons' panel."""

    def __init__(self, page: PanelContext) -> None:
        self._gui, self._session, self._exports = (
            page.client.gui,
            page.session,
            page.panel(ExportsPanel).exports,
        )
        view = page.view.part(LessonView)
        self._lessons, self._panel = view.lessons, view.panel
        self._address = request_address(page.client)
        self._shown: Recorded | None = None
        self._handles: tuple[viser.GuiHtmlHandle, viser.GuiButtonHandle] | None = None
        page.handlers.add(AskPushFilm, self._ask_film)

    def _ask_film(self, action: AskPushFilm) -> None:
        del action
        if self._shown is not None:
            self._exports.make(
                N_("the film"), "duet-push.webp", make_push_film, spoken().language, self._shown
            )

    def show(self, frame: Frame) -> None:
        del frame
        run, tab = self._lessons, self._panel.tab
        nearest = run.walk.nearest if run.open and not run.listing and tab is not None else None
        if self._handles is None and nearest is not None and tab is not None:
            hint = tr("An animated picture (WebP) of the nearest moment; it takes half a minute.")
            with tab:
                link = self._gui.add_html("", order=ORDER["attempt"] + 1.0)
                film = self._gui.add_button(
                    tr("Film of five seconds"), hint=hint, color="gray", order=ORDER["attempt"] + 2.0
                )
            self._handles = link, on_press(film, lambda: self._session.post(AskPushFilm()))
        if self._handles is None:
            return
        link, film = self._handles
        if nearest is not self._shown:
            self._shown = nearest
            link.visible = film.visible = nearest is not None
            link.content = "" if nearest is None else self._link(nearest)
        film.disabled = bool(self._exports.busy)

    def _link(self, push: Recorded) -> str:
        walk = self._lessons.walk
        try:
            query = {"lesson": walk.lesson.id, "step": str(walk.step_index + 1), PUSH: run_text(push)}
        except BadSetting as error:
            return element("p", tr(str(error)), class_="duet")
        made = macros("page/panels/copy.html").link
        return made(link_to(self._address, query), False, tr("Link that replays your nearest push"))
