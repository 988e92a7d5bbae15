"""The page of a group's member who watches while another one operates the session that they share."""

import logging

import viser

from app.classroom.classroom_html import WATCHING
from app.classroom.plenary_page import PlenaryPage
from app.hosting.app_context import AppContext
from app.hosting.visitor import Visitor
from app.i18n.reader_language import look_of
from app.i18n.speaking import set_language, tr
from app.runtime.throttled_log import ThrottledLog
from app.session.frame import Frame
from app.web.request import browser_language, request_query

log = logging.getLogger("duet.lecture")


class GroupMember:
    """The session of a group in a member's own language and look. Belongs to the frame loop's thread.

    Args:
        lead: the member who operates it.

    Attributes:
        view, language, lessons: what is seen of it.
    """

    def __init__(self, context: AppContext, client: viser.ClientHandle, lead: Visitor) -> None:
        self.client, self._server, self._errors = client, context.server, ThrottledLog(log)
        self._session, self.lessons = lead.session, lead.lessons
        look = look_of(request_query(client), browser_language(client), context.options.settings)
        with client.atomic():
            # After a page of an earlier session.
            client.gui.reset()
            self._page = PlenaryPage(
                client,
                lead.session,
                lead.lessons,
                context.book,
                look.language,
                look,
                lambda: [client],
                tip=lambda _: tr(WATCHING),
            )
            self.view, self.language = self._page.view, look.language
            self.view.welcome(client)

    def watches(self, lead: Visitor) -> bool:
        """Return whether it still shows the session and the lessons of who operates; in another language these are new ones."""
        return self._session is lead.session and self.lessons is lead.lessons

    def act(self) -> None:
        """Do nothing: the page has nothing to operate."""

    def show(self, frame: Frame) -> None:
        """Draw a frame."""
        set_language(self.language)
        try:
            self._page.show(frame, None)
            self._page.flush()
        except Exception as error:
            # A tab that is just closing has no page any more; the others must not lose a frame.
            if self.client.client_id in self._server.get_clients():
                self._errors.exception("a frame of a member's page failed", error, self.client.client_id)
