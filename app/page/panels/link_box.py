"""The link to the page as it is now, which a visitor passes on."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Final
from urllib.parse import urlencode

import viser

from app.lessons.session.lesson_session import LessonSession
from app.session.counterexample_search import NAME
from app.session.frame import Frame, freeze
from app.session.session import Session
from app.settings import ATTACK, Settings, to_query
from app.text.templates import macros
from app.web.request import frames_of, request_address
from scenes.counterexample import Attack

PERIOD: Final = 0.5
"""Time between two writes of the link [s]; while a slider is dragged it need not follow."""

OF_LESSONS: Final = ("scene", "rig", "robot", "autopilot", "ghost", "whatif", "plot", "speed", "lever")
"""What a step decides by itself, and a link to it need not say."""


def attack_query(settings: Settings, attack: Attack) -> dict[str, str]:
    """Return what a link says that replays an attack to break the promise."""
    return {**to_query(replace(settings, run=attack.settings)), ATTACK: attack.text()}


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
    """

    def __init__(self, client: viser.ClientHandle, session: Session, lessons: LessonSession) -> None:
        self._lessons = lessons
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
        attack = None if frame.studies is None else frame.studies.counterexample.replayed
        if frame.shown.replayed_file == NAME and attack is not None:
            query = attack_query(settings, attack)
        else:
            query = link_query(settings, self._lessons)
        link = link_to(self._address, query)
        self._box.content = macros("page/panels/copy.html").link(link, self._frames)
