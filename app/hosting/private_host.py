"""A private session for every tab."""

import logging

import viser

from app.hosting.admission import Admission, Pieces
from app.hosting.app_context import AppContext
from app.hosting.guest import Guest
from app.hosting.teacher_key import is_mistaken
from app.hosting.visitor import Visitor
from app.hosting.visitor_record import same_tab, tab_id
from app.hosting.worker_messages import Invited, LetGo, MakeRoom, WorkerLink
from app.page.panels.teachers_tab import name_mistake
from app.settings import GUEST, from_query
from app.web.request import request_query

log = logging.getLogger("duet.hosts")


class PrivateHost:
    """Every tab has its own session. `visitors`: by client id, once their pages are built."""

    def __init__(self, context: AppContext) -> None:
        self._context = context
        self.visitors: dict[int, Visitor] = {}
        self._guests: dict[int, Guest] = {}
        self._announced: set[str] = set()
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
            if client_id in self._guests:
                self._guests.pop(client_id).leave()
            if client_id in self.visitors:
                self.visitors.pop(client_id).leave()
        for client in arrivals:
            self.admission.come(client)
        if self._context.link is not None:
            self._listen(self._context.link)
        self._context.server.max_clients = self._context.workload.places
        self.admission.advance()
        self._bring_guests()
        for client_id, visitor in list(self.visitors.items()):
            with self._context.apart("a frame of a visitor's page failed", client_id):
                visitor.frame(now, elapsed)

    def _listen(self, link: WorkerLink) -> None:
        """Send guests to their host, and tabs that wait for their pages to another worker, once there is one with more room."""
        for message in link.received():
            if isinstance(message, Invited):
                for guest in self._guests.values():
                    if guest.word == message.word:
                        guest.come_again()
            elif isinstance(message, MakeRoom):
                too_many = self._context.server.count_clients() - message.share
                for client in self.admission.send_on(too_many, self._may_go):
                    link.send(LetGo(tab_id(request_query(client)) or ""))
                    self._context.server.send_elsewhere(client)

    @property
    def _hosts(self) -> dict[str, Visitor]:
        """The visitors who have invited a guest, by the word of the invitation."""
        return {one.session.invitation: one for one in self.visitors.values() if one.session.invitation and not one.superseded}

    def _bring_guests(self) -> None:
        """Bring every guest to their host; other processes send those of this one here."""
        hosts = self._hosts
        for visitor in self.visitors.values():
            visitor.beside = ()
        for guest in self._guests.values():
            guest.follow(hosts.get(guest.word))
        if self._context.link is not None:
            for word in hosts.keys() - self._announced:
                self._announced.add(word)
                self._context.link.send(Invited(word))

    def _admit_guest(self, client: viser.ClientHandle) -> Pieces:
        guest = Guest(self._context, client)
        try:
            yield from guest.build(self._hosts.get(guest.word))
        except BaseException:
            guest.leave()
            raise
        self._guests[client.client_id] = guest

    def _may_go(self, client: viser.ClientHandle) -> bool:
        query = request_query(client)
        return GUEST not in query and not self._context.store.alone_has(query)

    def _admit(self, client: viser.ClientHandle) -> Pieces:
        """Build a visitor's page piece by piece; it is drawn once it is whole."""
        context, query = self._context, request_query(client)
        if GUEST in query:
            yield from self._admit_guest(client)
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
        if before and not visitor.lessons.open and before[-1].session.settings == settings:
            # It has gone on while the page was built.
            yield from visitor.session.go_on_from(before[-1].session.state())
        parked = context.store.claim(query) if before else None
        if parked is not None:
            # The earlier connection turned out to be broken while the page was built.
            parked[0].close()
        self.visitors[client.client_id] = visitor
        if is_mistaken(context.options.key, query):
            name_mistake(client)
