"""The projector's part of the stage's page: what lies over the scene, and the black picture."""

import viser

from app.classroom.classroom import Poll
from app.classroom.presenter import Presenter
from app.classroom.screen_html import screen_html
from app.lessons.lesson import LessonBook
from app.lessons.session.lesson_session import LessonSession
from app.text.html_element import element


class ScreenView:
    """What the projectors of one look show beside the stage.

    Args:
        gui: of the projectors.
        book: the lessons in their language.
    """

    def __init__(self, gui: viser.GuiApi, presenter: Presenter, lessons: LessonSession, book: LessonBook) -> None:
        self._presenter, self._lessons, self._book = presenter, lessons, book
        self._over, self._cover = gui.add_html(""), gui.add_html("")
        self._shown: object = None
        self._black = False

    def show(self, poll: Poll | None) -> None:
        """Update what lies over the scene. `poll`: the question on the stage, in the projector's language."""
        presenter, lessons = self._presenter, self._lessons
        left = presenter.left
        # The curves of a whole class are not drawn in every frame.
        shown = presenter.station, presenter.panels, lessons.open, lessons.version, poll, left
        if shown == self._shown:
            return
        self._shown = shown
        view = lessons.view(self._book) if lessons.open else None
        cues = ("panels",) if presenter.panels else ()
        self._over.content = screen_html(presenter.station, view, poll, left, cues)

    def cover(self) -> None:
        """Make the projector black, or show its picture again."""
        if self._presenter.blank != self._black:
            self._black = self._presenter.blank
            self._cover.content = element("i", class_="duet-blank", hidden="") if self._black else ""
