"""Private sessions of one worker among several."""

import viser

from app.features.workers.worker_messages import Announced, LetGo, MakeRoom, WorkerLink
from app.hosting.app_context import AppContext
from app.hosting.private_host import PrivateHost
from app.hosting.visitor_record import tab_id
from app.web.request import request_query


class WorkerHost(PrivateHost):
    """Host that sends tabs to workers that have them, or more room."""

    def __init__(self, context: AppContext, link: WorkerLink) -> None:
        super().__init__(context)
        self._link = link
        self._announced: set[str] = set()

    def connect(self) -> None:
        super().connect()
        for message in self._link.received():
            if isinstance(message, Announced):
                for pages in self.joining:
                    pages.opened_elsewhere(message.word)
            elif isinstance(message, MakeRoom):
                too_many = self.context.server.count_clients() - message.share
                for client in self.admission.send_on(too_many, self._may_go):
                    self._link.send(LetGo(tab_id(request_query(client)) or ""))
                    self.context.server.send_elsewhere(client)

    def join(self) -> None:
        super().join()
        words = {word for pages in self.joining for word in pages.words(self.visitors.values())}
        for word in words - self._announced:
            self._announced.add(word)
            self._link.send(Announced(word))

    def _may_go(self, client: viser.ClientHandle) -> bool:
        query = request_query(client)
        return self.joined(query) is None and not self.context.store.alone_has(query)
