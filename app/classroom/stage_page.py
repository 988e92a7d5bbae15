"""The stage of a lecture as one audience sees it, or one teacher on a page of their own: in their language, with their look."""

from collections.abc import Callable

import viser

from app.classroom.address import Address
from app.classroom.classroom import Poll
from app.classroom.stage_overlays import Overlays
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
    """Made and used on the frame loop's thread.

    Args:
        host: who sees it.
        session, lessons: the stage's.
        book: the lessons, in English.
        language: of those who see it.
        look: of those who see it; None for what the stage's settings say, which is the look of the one who leads.
        clients: returns whose cameras follow.

    Attributes:
        view: what is seen.
        language, book: spoken there, and the lessons in it.
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
            self._overlays = Overlays(host.gui, self.view)

    def show(self, frame: Frame, poll: Poll | None, inviting: Address | None) -> None:
        """Draw a frame.

        Args:
            frame: of the stage's session.
            poll: the question on the stage, in this language.
            inviting: the address, while it is to be on every screen.
        """
        with self._host.atomic():
            self.view.show(frame)
            self._overlays.show(poll, inviting)

    def flush(self) -> None:
        """Send at once what was drawn."""
        self._host.flush()
