"""A lecture on the wire, whose teacher is in lesson 1, and what its pages see and press."""

import re
from collections.abc import Callable
from typing import Any

from app.features.lecture.breakout_host import BreakoutHost
from app.features.lecture.lecture import LectureHost
from app.page.panels.choice_buttons import MARK
from app.session.session import Session
from app.start import App
from app.web.server import MOVED_CODE
from tests.app.conftest import ByHand, OpenHouse, ask
from tests.app.page.helpers import bodies, open_lessons, shown
from tests.app.web.conftest import ended
from tests.blocking_client import BlockingClient

KEY = "chalk ü"


WAIT = 60.0


Come = Callable[..., BlockingClient]


def lecture_of(house: App | ByHand) -> LectureHost:
    assert isinstance(house.host, LectureHost)
    return house.host


def operator_of(host: LectureHost) -> int | None:
    """Id of the client that has the controls, or None."""
    operator = host.controls.operator
    return None if operator is None else operator.client.client_id


def tab_of(name: str) -> str:
    """The id of a student's tab."""
    return f"{name.encode().hex():0<32}"


def sessions_of(host: LectureHost | BreakoutHost) -> dict[int, Session]:
    """The breakout sessions of a host, by client id."""
    return {
        key: one.visitor.session for key, one in list(host.participants.items()) if one.visitor is not None
    }


def sees(visitor: BlockingClient, *texts: str) -> None:
    try:
        visitor.wait_for(lambda _: all(text in shown(visitor) for text in texts), WAIT)
    except TimeoutError as error:
        raise AssertionError(
            f"{[t for t in texts if t not in shown(visitor)]} not in {shown(visitor)[-3000:]}"
        ) from error


def choose(visitor: BlockingClient, label: str) -> None:
    """Press one of a row of buttons."""

    found: list[tuple[str, str]] = []

    def is_there(_: object) -> bool:
        rows = bodies(visitor, "GuiButtonGroupMessage")
        found[:] = [
            (row["uuid"], o) for row in rows for o in row["options"] if str(o).removeprefix(MARK) == label
        ]
        return bool(found)

    visitor.wait_for(is_there, WAIT)
    uuid, value = found[0]
    visitor.send({"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": value}})


def command(visitor: BlockingClient, name: str) -> None:
    """Do something by its name, as the palette and the keys do."""
    visitor.wait_for(lambda v: any(c["label"] == name for c in list(v.mirror.commands.values())), WAIT)
    uuid = next(uuid for uuid, c in list(visitor.mirror.commands.items()) if c["label"] == name)
    visitor.send({"type": "CommandTriggerMessage", "uuid": uuid})


def drawn_name(student: BlockingClient) -> str:
    found = re.search(r"For the teacher you are ([^.<]+)\.", shown(student))
    assert found is not None, shown(student)[-2000:]
    return found[1]


class Class:
    """A lecture, whose teacher is in lesson 1, and its students by their names."""

    def __init__(self, house: OpenHouse, come: Come, **options: Any) -> None:
        self.opened, self._come = house(lecture=True, key=KEY, **options), come
        self.host = lecture_of(self.opened)
        self.teacher = come(self.opened, key=KEY)
        self.students: dict[str, BlockingClient] = {}
        open_lessons(self.teacher)
        sees(self.teacher, "Lesson 1 · step 1")

    def come(self, *names: str) -> list[BlockingClient]:
        self.students |= {name: self._come(self.opened, name) for name in names}
        return [self.students[name] for name in names]

    def send(self, label: str, *names: str) -> list[BlockingClient]:
        """The teacher chooses where the students work, and their pages are asked to come again, and do."""
        choose(self.teacher, label)
        for name in names:
            self.is_sent_away(name)
        return self.come(*names)

    def is_sent_away(self, name: str) -> None:
        """Wait until a student's page is asked to come again."""
        assert ended(self.students[name])[0] == MOVED_CODE

    def number(self, name: str) -> int:
        """Wait until a student has a session of their own, and return its number."""
        visitor = self.students[name]
        visitor.wait_for(lambda v: bodies(v, "GuiSliderMessage"), WAIT)
        (owner,) = {str(node["owner"]) for node in list(visitor.mirror.nodes.values()) if node.get("owner")}
        visitor.wait_for(lambda _: int(owner) in sessions_of(self.host), WAIT)
        return int(owner)

    def critical_distance(self, name: str) -> float:
        return ask(sessions_of(self.host)[self.number(name)], lambda s: s.settings.run.law.critical_distance)
