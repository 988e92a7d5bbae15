"""What lies over a page of a lecture: the address, and on a projector the question, the answers, and the black picture."""

import contextlib

import viser

from app.classroom.classroom import Poll
from app.classroom.classroom_html import overlay_html
from app.classroom.presenter import Presenter
from app.classroom.screen_html import screen_html, work_html
from app.lessons.lesson import LessonBook
from app.lessons.session.lesson_session import LessonSession
from app.page.view import View
from app.text.templates import element
from app.web.address import Address


class Invitation:
    """The address over a teacher's or a student's page. A page that opens while the address is shown does not get it."""

    def __init__(self, gui: viser.GuiApi, view: View) -> None:
        self._gui, self._view = gui, view
        self._handles: dict[str, viser.GuiHtmlHandle] = {}
        self._late, self._shown = True, False

    def show(self, address: Address | None) -> None:
        """Show the address; None takes it away."""
        self._late = self._late and address is not None
        if self._late or self._shown == (address is not None):
            return
        content = "" if address is None else overlay_html(address)
        # A folded panel is not on the page; one of several is.
        places = {"main": contextlib.nullcontext(), "plots": self._view.plots_tab, "lesson": self._view.lesson_panel.tab}
        for name, place in places.items():
            if place is not None and name not in self._handles:
                with place:
                    self._handles[name] = self._gui.add_html("")
        for handle in self._handles.values():
            handle.content = content
        # What fails on its way is shown with the next frame.
        self._shown = address is not None


class ScreenView:
    """What the projectors of one look show beside the plenary.

    Args:
        gui: of the projectors.
        book: the lessons in their language.
    """

    def __init__(self, gui: viser.GuiApi, presenter: Presenter, lessons: LessonSession, book: LessonBook) -> None:
        self.presenter, self._lessons, self._book = presenter, lessons, book
        self._over, self._cover = gui.add_html(""), gui.add_html("")
        self._shown: object = None
        self._covered: tuple[bool, Address | None, tuple[int, int]] = False, None, (0, 0)

    def show(self, poll: Poll | None, record: float | None) -> None:
        """Update what lies over the scene.

        Args:
            poll: the question in the plenary, in the projector's language.
            record: see `screen_html`.
        """
        presenter, lessons = self.presenter, self._lessons
        left = presenter.left
        # The curves of a whole class are not drawn in every frame.
        class_says = poll, presenter.work, presenter.quotes, record
        shown = presenter.station, presenter.panels, lessons.open, lessons.version, left, class_says
        if shown == self._shown:
            return
        self._shown = shown
        view = lessons.view(self._book) if lessons.open else None
        if presenter.work is not None:
            self._over.content = work_html(presenter.work, self._book)
        else:
            self._over.content = screen_html(presenter.station, view, poll, left, presenter.panels, presenter.quotes, record)

    def cover(self, address: Address | None, joined: tuple[int, int]) -> None:
        """Make the projector black, or show the address, or its picture again. `joined`: see `joined_text`."""
        covered = self.presenter.blank, address, joined if address is not None else (0, 0)
        if covered != self._covered:
            self._covered = covered
            black = element("i", class_="duet-blank", hidden="") if self.presenter.blank else ""
            self._cover.content = black + ("" if address is None else overlay_html(address, joined))
