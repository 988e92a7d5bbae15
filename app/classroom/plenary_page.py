"""The plenary of a lecture in the language and look of one audience, or of one teacher; over it the class's answers."""

from collections.abc import Callable

import viser

from app.classroom.classroom import Poll
from app.classroom.classroom_html import poll_html, tied_html
from app.classroom.overlays import ScreenView
from app.classroom.presenter import Presenter
from app.i18n.speaking import set_language
from app.lessons.lesson import LessonBook
from app.lessons.loading import in_language
from app.lessons.session.lesson_session import LessonSession
from app.page.lessons.lesson_html import record_html
from app.page.lessons.lesson_panel import ORDER
from app.page.view import View
from app.session.frame import Frame, Shown
from app.session.session import Session
from app.settings import Language, Look
from app.web.address import Address
from app.web.audiences import Audience


class PlenaryPage:
    """A page that shows the plenary. Belongs to the frame loop's thread.

    Args:
        host: the audience, or the teacher's client.
        book: the lessons, in English.
        look: of the page; None for that of the stage's settings, which is the operator's.
        clients: returns the clients to which the camera belongs.
        presenter: of a projector's page; None for all others.
        tip: see `app.page.view.View`.

    Attributes:
        language, book: of the page, and the lessons in it.
        shown: whether a frame was drawn.
    """

    def __init__(
        self,
        host: Audience | viser.ClientHandle,
        session: Session,
        lessons: LessonSession,
        book: LessonBook,
        language: Language,
        look: Look | None,
        clients: Callable[[], list[viser.ClientHandle]],
        presenter: Presenter | None = None,
        tip: Callable[[Shown], str] | None = None,
    ) -> None:
        self._host, self.book = host, in_language(book, language)
        self._clients, self._presenter, self.shown = clients, presenter, False
        self.language: Language = language
        set_language(language)
        with host.atomic():
            self.view = View(host, session, clients, lessons, look, self.book, folds=False, tip=tip)
            self._screen = None if presenter is None else ScreenView(host.gui, presenter, lessons, self.book)
        self._poll: viser.GuiHtmlHandle | None = None
        self._shown: tuple[Poll | None, float | None] = None, None

    def _show_screen(self, presenter: Presenter, screen: ScreenView, poll: Poll | None, record: float | None) -> None:
        if self.view.bare == presenter.panels:
            self.view.bare = not presenter.panels
            for client in self._clients():
                # The panels take their room from the canvas, so that the view has to be fitted again.
                self.view.welcome(client)
        screen.show(poll, record)

    def cover(self, address: Address | None, joined: tuple[int, int]) -> None:
        """Make a projector black, or show the address on it, or its picture again, which may be frozen. `joined`: see `joined_text`."""
        if self._screen is not None:
            set_language(self.language)
            self._screen.cover(address, joined)

    def show(self, frame: Frame, poll: Poll | None, record: float | None = None) -> None:
        """Draw a frame.

        Args:
            poll: the question on the stage, in this language; its tally is shown after the reveal.
            record: of the class in the duel on the stage [m]; None for none.
        """
        self.shown = True
        with self._host.atomic():
            if self._presenter is not None and self._screen is not None:
                self._show_screen(self._presenter, self._screen, poll, record)
            self.view.show(frame)
            tab, gui = self.view.lesson_panel.tab, self._host.gui
            if self._poll is None and tab is not None:
                with tab:
                    self._poll = gui.add_html("", order=ORDER["verdict"] - 0.5)
            # The curves of a whole class are not drawn in every frame.
            if self._poll is not None and (poll, record) != self._shown:
                self._shown = poll, record
                answers = poll_html(poll) + tied_html(poll) if poll is not None and poll.revealed else ""
                self._poll.content = answers + record_html(record)

    def flush(self) -> None:
        """Send the frame at once."""
        self._host.flush()
