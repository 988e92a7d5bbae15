"""All guests of one process."""

from collections.abc import Collection, Mapping

import viser

from app.features.second_person.guest import Guest, place_of
from app.hosting.admission import Pieces
from app.hosting.app_context import AppContext
from app.hosting.visitor import Visitor
from app.settings import JOIN


class Guests:
    """See `app.hosting.joining_pages.JoiningPages`."""

    def __init__(self, context: AppContext) -> None:
        self._context = context
        self._guests: dict[int, Guest] = {}

    def expects(self, query: Mapping[str, str]) -> bool:
        return JOIN in query

    def build(self, client: viser.ClientHandle, visitors: Collection[Visitor]) -> Pieces:
        guest = Guest(self._context, client)
        try:
            yield from guest.build(_hosts(visitors).get(guest.word))
        except BaseException:
            guest.leave()
            raise
        self._guests[client.client_id] = guest

    def leave(self, client_id: int) -> None:
        if client_id in self._guests:
            self._guests.pop(client_id).leave()

    def follow(self, visitors: Collection[Visitor]) -> None:
        hosts = _hosts(visitors)
        for guest in self._guests.values():
            guest.follow(hosts.get(guest.word))

    def words(self, visitors: Collection[Visitor]) -> Collection[str]:
        return _hosts(visitors)

    def opened_elsewhere(self, word: str) -> None:
        for guest in self._guests.values():
            if guest.word == word:
                guest.come_again()


def _hosts(visitors: Collection[Visitor]) -> dict[str, Visitor]:
    return {place_of(one).word: one for one in visitors if place_of(one).word and not one.superseded}
