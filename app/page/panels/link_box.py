"""The link to the page as it is now, which a visitor passes on."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Final
from urllib.parse import urlencode

import viser

from app.session.counterexample_search import NAME
from app.session.frame import Frame, freeze
from app.session.session import Session
from app.settings import ATTACK, Settings, to_query
from app.text.templates import macros
from app.web.request import frames_of, request_address
from scenes.counterexample import Attack

PERIOD: Final = 0.5
"""Time between two writes of the link [s]; while a slider is dragged it need not follow."""


def attack_query(settings: Settings, attack: Attack) -> dict[str, str]:
    """Return what a link says that replays an attack to break the promise."""
    return {**to_query(replace(settings, run=attack.settings)), ATTACK: attack.text()}


def link_query(session: Session) -> dict[str, str]:
    """Query of a link to the present page."""
    query = to_query(session.settings)
    for part in session.parts:
        query = part.link(query)
    return query


def link_to(address: str, query: Mapping[str, str]) -> str:
    """Return the link: address of the page, such as http://localhost:8080, and what it says."""
    return f"{address}/?{urlencode(query)}"


class LinkBox:
    """A line with the link, and a button that copies it.

    Args:
        client: who gets it; its container is open.
        session: what the link opens again.
    """

    def __init__(self, client: viser.ClientHandle, session: Session) -> None:
        self._session = session
        self._address, self._frames = request_address(client), frames_of(client)
        self._box = client.gui.add_html("")
        self._next = 0.0
        self.show(freeze(session, 0.0))

    def show(self, frame: Frame) -> None:
        """Bring the link up to date, every `PERIOD`."""
        if frame.now < self._next:
            return
        self._next = frame.after(PERIOD)
        attack = None if frame.studies is None else frame.studies.counterexample.replayed
        if attack is None or frame.shown.replayed_file != NAME:
            query = link_query(self._session)
        else:
            query = attack_query(frame.live.settings, attack)
        link = link_to(self._address, query)
        self._box.content = macros("page/panels/copy.html").link(link, self._frames)
