"""The host of private sessions."""

import logging
from collections.abc import Mapping

import viser

from app.hosting.admission import Admission, Pieces
from app.hosting.app_context import AppContext
from app.hosting.joining_pages import Joining, JoiningPages
from app.hosting.teacher_key import is_mistaken
from app.hosting.visitor import Visitor
from app.hosting.visitor_record import same_tab, tab_id
from app.page.panels.key_notice import name_mistake
from app.session.session_state import go_on_from, state_of
from app.settings import first_settings
from app.web.request import request_query

log = logging.getLogger("duet.hosts")


class PrivateHost:
    """A private session for every tab, except tabs that join another's.

    Attributes:
        visitors: by client id, once their pages are built.
    """

    def __init__(self, context: AppContext) -> None:
        self.context = context
        self.visitors: dict[int, Visitor] = {}
        joining = context.given(Joining) or Joining()
        self.joining = tuple(make(context) for make in joining.makers)
        self.admission = Admission(
            context, self._admit, lambda _: log.exception("a visitor's page could not be built")
        )

    def close(self, goes_on: bool = False) -> None:
        del goes_on
        self.admission.close()
        for visitor in self.visitors.values():
            visitor.save()
            visitor.session.close()
        self.context.store.close()

    def frame(self, now: float, elapsed: float) -> None:
        self.connect()
        self.context.server.max_clients = self.context.workload.places
        self.admission.advance()
        self.join()
        for client_id, visitor in list(self.visitors.items()):
            with self.context.guarded("a frame of a visitor's page failed", client_id):
                visitor.frame(now, elapsed)

    def connect(self) -> None:
        arrivals, departures = self.admission.changes()
        self.context.store.tidy()
        for client_id in departures:
            self.context.errors.forget(client_id)
            for pages in self.joining:
                pages.leave(client_id)
            if client_id in self.visitors:
                self.visitors.pop(client_id).leave()
        for client in arrivals:
            self.admission.come(client)

    def join(self) -> None:
        for visitor in self.visitors.values():
            visitor.beside = ()
        for pages in self.joining:
            pages.follow(self.visitors.values())

    def joined(self, query: Mapping[str, str]) -> JoiningPages | None:
        """Pages of this link; None if it asks for its own session."""
        return next((pages for pages in self.joining if pages.expects(query)), None)

    def _admit(self, client: viser.ClientHandle) -> Pieces:
        context, query = self.context, request_query(client)
        joined = self.joined(query)
        if joined is not None:
            yield from joined.build(client, self.visitors.values())
            return
        settings, problems = first_settings(query, context.options.settings, context.options.glides_as_usual)
        # The tab's earlier connection may still be open, or a duplicated tab keeps its own session.
        tab = tab_id(query)
        before = [
            one for one in self.visitors.values() if tab and not one.superseded and tab_id(one.query) == tab
        ]
        for visitor in before:
            visitor.save()
        # A run that continues from an earlier connection needs no store.
        record = before[-1].record() if before else (yield from context.store.recall(query))
        if record is not None and record.state is not None and same_tab(record.query, query):
            settings = record.settings
        visitor = Visitor(context, client, settings, problems, record, private=True)
        yield from visitor.build()
        for one in before:
            one.superseded = True
        before = [one for one in before if same_tab(one.query, query)]
        if before and not visitor.session.parts.lead and before[-1].session.settings == settings:
            # The earlier session has advanced while the page was built.
            yield from go_on_from(visitor.session, state_of(before[-1].session))
        parked = context.store.claim(query) if before else None
        if parked is not None:
            # The earlier connection turned out to be broken while the page was built.
            parked.close()
        self.visitors[client.client_id] = visitor
        if is_mistaken(context.options.key, query):
            name_mistake(client)
