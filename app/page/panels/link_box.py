"""Link to the page's present state."""

from collections.abc import Callable, Mapping, Sequence
from typing import Final
from urllib.parse import urlencode

import viser

from app.session.frame import Frame, freeze
from app.session.session import Session
from app.settings import to_query
from app.text.templates import macros
from app.web.request import frames_of, request_address

PERIOD: Final = 0.5
"""Time between two updates of the link [s]."""


def link_query(session: Session) -> dict[str, str]:
    query = to_query(session.settings)
    for part in session.parts:
        query = part.link(query)
    return query


def link_to(address: str, query: Mapping[str, str]) -> str:
    """`address`: such as http://localhost:8080."""
    return f"{address}/?{urlencode(query)}"


class PageLink:
    """`links`: of features, see `PanelContext.links`."""

    def __init__(
        self,
        client: viser.ClientHandle,
        session: Session,
        links: Sequence[Callable[[Frame], Mapping[str, str] | None]] = (),
    ) -> None:
        self._session, self._links = session, links
        self._address = request_address(client)
        self._next = 0.0

    def due(self, frame: Frame) -> str | None:
        """Link to a frame; None if the last one is younger than `PERIOD`."""
        if frame.now < self._next:
            return None
        self._next = frame.after(PERIOD)
        said = (link(frame) for link in self._links)
        query = next((query for query in said if query is not None), None) or link_query(self._session)
        return link_to(self._address, query)


class LinkBox:
    """Line with the link and a button that copies it."""

    def __init__(
        self,
        client: viser.ClientHandle,
        session: Session,
        links: Sequence[Callable[[Frame], Mapping[str, str] | None]] = (),
    ) -> None:
        self._link, self._frames = PageLink(client, session, links), frames_of(client)
        self._box = client.gui.add_html("")
        self.show(freeze(session, 0.0))

    def show(self, frame: Frame, seen: bool = True) -> None:
        """`seen`: False while the box is not on the page."""
        link = self._link.due(frame) if seen else None
        if link is not None:
            self._box.content = macros("page/panels/copy.html").link(link, self._frames)
