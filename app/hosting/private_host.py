"""A private session for every tab."""

import logging
from collections.abc import Callable, Mapping, Sequence

import viser

from app.hosting.admission import Admission, Pieces
from app.hosting.app_context import AppContext
from app.hosting.joining_pages import JoiningPages
from app.hosting.teacher_key import is_mistaken
from app.hosting.visitor import Visitor
from app.hosting.visitor_record import same_tab, tab_id
from app.hosting.worker_messages import Announced, LetGo, MakeRoom, WorkerLink
from app.page.panels.key_notice import name_mistake
from app.settings import from_query
from app.web.request import request_query

log = logging.getLogger("duet.hosts")


class PrivateHost:
    """Every tab has its own session, except those that join another one's.

    Args:
        joining: makes the pages of those.

    Attributes:
        visitors: by client id, once their pages are built.
    """

    def __init__(self, context: AppContext, joining: Sequence[Callable[[AppContext], JoiningPages]] = ()) -> None:
        self._context = context
        self.visitors: dict[int, Visitor] = {}
        self._joining = tuple(make(context) for make in joining)
        self.admission = Admission(context, self._admit, lambda _: log.exception("a visitor's page could not be built"))

    def close(self, goes_on: bool = False) -> None:
        """Keep what every visitor has done, and close every session, also of visitors who are away."""
        del goes_on
        self.admission.close()
        for visitor in self.visitors.values():
            visitor.save()
            visitor.session.close()
        self._context.store.close()

    def frame(self, now: float, elapsed: float) -> None:
        """Advance and draw every session."""
        arrivals, departures = self.admission.changes()
        self._context.store.tidy()
        for client_id in departures:
            self._context.errors.forget(client_id)
            for pages in self._joining:
                pages.leave(client_id)
            if client_id in self.visitors:
                self.visitors.pop(client_id).leave()
        for client in arrivals:
            self.admission.come(client)
        if self._context.link is not None:
            self._listen(self._context.link)
        self._context.server.max_clients = self._context.workload.places
        self.admission.advance()
        for visitor in self.visitors.values():
            visitor.beside = ()
        for pages in self._joining:
            pages.follow(self.visitors.values())
        for client_id, visitor in list(self.visitors.items()):
            with self._context.apart("a frame of a visitor's page failed", client_id):
                visitor.frame(now, elapsed)

    def _listen(self, link: WorkerLink) -> None:
        """Hear what other workers announce, and send tabs that wait for their pages to another worker, once one has more room."""
        for message in link.received():
            if isinstance(message, Announced):
                for pages in self._joining:
                    pages.receive(message.word)
            elif isinstance(message, MakeRoom):
                too_many = self._context.server.count_clients() - message.share
                for client in self.admission.send_on(too_many, self._may_go):
                    link.send(LetGo(tab_id(request_query(client)) or ""))
                    self._context.server.send_elsewhere(client)

    def _joined(self, query: Mapping[str, str]) -> JoiningPages | None:
        """The pages to which a link belongs; None if it asks for a session of its own."""
        return next((pages for pages in self._joining if pages.expects(query)), None)

    def _may_go(self, client: viser.ClientHandle) -> bool:
        query = request_query(client)
        return self._joined(query) is None and not self._context.store.alone_has(query)

    def _admit(self, client: viser.ClientHandle) -> Pieces:
        """Build a visitor's page piece by piece; it is drawn once it is whole."""
        context, query = self._context, request_query(client)
        joined = self._joined(query)
        if joined is not None:
            yield from joined.build(client, self.visitors.values())
            return
        settings, problems = from_query(query, context.options.settings)
        # The tab's earlier connection may not have been noticed to be gone, or the tab was doubled and keeps a session of its own.
        tab = tab_id(query)
        before = [one for one in self.visitors.values() if tab and not one.superseded and tab_id(one.query) == tab]
        for visitor in before:
            visitor.save()
        record = yield from context.store.recall(query)
        if record is not None and record.state is not None and same_tab(record.query, query):
            settings = record.settings
        visitor = Visitor(context, client, settings, problems, record, private=True)
        yield from visitor.build()
        for one in before:
            one.superseded = True
        before = [one for one in before if same_tab(one.query, query)]
        if before and not visitor.session.parts.lead and before[-1].session.settings == settings:
            # It has gone on while the page was built.
            yield from visitor.session.go_on_from(before[-1].session.state())
        parked = context.store.claim(query) if before else None
        if parked is not None:
            # The earlier connection turned out to be broken while the page was built.
            parked.close()
        self.visitors[client.client_id] = visitor
        if is_mistaken(context.options.key, query):
            name_mistake(client)
