"""The link to the page as it is now, which a visitor passes on."""

from collections.abc import Callable, Mapping, Sequence
from typing import Final
from urllib.parse import urlencode

import viser

from app.lessons.session.lesson_session import LessonSession
from app.session.frame import Frame, freeze
from app.session.session import Session
from app.settings import Settings, to_query
from app.text.templates import macros
from app.web.request import frames_of, request_address

PERIOD: Final = 0.5
"""Time between two writes of the link [s]; while a slider is dragged it need not follow."""

OF_LESSONS: Final = ("scene", "rig", "robot", "autopilot", "ghost", "whatif", "plot", "speed", "lever")
"""What a step decides by itself, and a link to it need not say."""


def link_query(settings: Settings, lessons: LessonSession) -> dict[str, str]:
    """Return what a link to the present page says."""
    if not lessons.open:
        return to_query(settings)
    walk = lessons.walk
    query = to_query(settings, walk.setup.settings(Settings()))
    query = {key: text for key, text in query.items() if key not in OF_LESSONS}
    return {"lesson": walk.lesson.id, "step": str(walk.lesson.steps.index(walk.step) + 1), **query}


def link_to(address: str, query: Mapping[str, str]) -> str:
    """Return the link: address of the page, such as http://localhost:8080, and what it says."""
    return f"{address}/?{urlencode(query)}"


class LinkBox:
    """A line with the link, and a button that copies it.

    Args:
        client: who gets it; its container is open.
        session, lessons: what the link opens again.
        links: of features, see `PanelContext.links`.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        session: Session,
        lessons: LessonSession,
        links: Sequence[Callable[[Frame], Mapping[str, str] | None]] = (),
    ) -> None:
        self._lessons, self._links = lessons, links
        self._address, self._frames = request_address(client), frames_of(client)
        self._box = client.gui.add_html("")
        self._next = 0.0
        self.show(freeze(session, 0.0))

    def show(self, frame: Frame) -> None:
        """Bring the link up to date, every `PERIOD`."""
        if frame.now < self._next:
            return
        self._next = frame.after(PERIOD)
        settings = frame.live.settings
        said = (link(frame) for link in self._links)
        query = next((query for query in said if query is not None), None) or link_query(settings, self._lessons)
        link = link_to(self._address, query)
        self._box.content = macros("page/panels/copy.html").link(link, self._frames)
