"""The stage of a lecture in the language and look of one audience, or of one teacher."""

from collections.abc import Callable

import viser

from app.classroom.address import Address
from app.classroom.classroom import Poll
from app.classroom.stage_overlays import StageOverlays
from app.i18n.speaking import set_language
from app.lessons.lesson import LessonBook
from app.lessons.session.lesson_session import LessonSession
from app.lessons.translated_book import in_language
from app.page.view import View
from app.session.frame import Frame
from app.session.session import Session
from app.settings import Language, Look
from app.web.audience import Audience


class StagePage:
    """A page that shows the stage. Belongs to the frame loop's thread.

    Args:
        host: the audience, or the teacher's client.
        session, lessons: the stage's.
        book: the lessons, in English.
        language: of the page.
        look: of the page; None for that of the stage's settings, which is the operator's.
        clients: returns the clients to which the camera belongs.

    Attributes:
        view: of the stage.
        language, book: of the page, and the lessons in it.
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
    ) -> None:
        self._host, self.book = host, in_language(book, language)
        self.language: Language = language
        set_language(language)
        with host.atomic():
            self.view = View(host, session, clients, lessons, look, self.book, folds=False)
            self._overlays = StageOverlays(host.gui, self.view)

    def show(self, frame: Frame, poll: Poll | None, inviting: Address | None) -> None:
        """Draw a frame.

        Args:
            frame: of the stage's session.
            poll: the question on the stage, in this language.
            inviting: the address, while it is on every screen.
        """
        with self._host.atomic():
            self.view.show(frame)
            self._overlays.show(poll, inviting)

    def flush(self) -> None:
        """Send the frame at once."""
        self._host.flush()
