"""A lecture over real connections, with its teacher in lesson 1, and helpers for its pages."""

import html
import re
from collections.abc import Callable
from time import monotonic
from typing import Any

from app.features.lecture.breakout_host import BreakoutHost
from app.features.lecture.lecture import LectureHost
from app.features.lecture.teacher_panel import COMMANDS
from app.page.panels.choice_buttons import MARK
from app.session.session import Session
from app.start import App
from app.web.server import MOVED_CODE
from tests.app.conftest import ByHand, OpenHouse, ask
from tests.app.page.helpers import bodies, click, open_lessons, shown
from tests.app.web.conftest import ended
from tests.blocking_client import BlockingClient

KEY = "chalk ü"

WAIT = 60.0

Come = Callable[..., BlockingClient]

BY_KEY = {action: name for name, _, action in COMMANDS}
"""Teacher's action → its name in the palette."""


def lecture_of(house: App | ByHand) -> LectureHost:
    assert isinstance(house.host, LectureHost)
    return house.host


def operator_of(host: LectureHost) -> int | None:
    """Client id of the operator, or None."""
    operator = host.controls.operator
    return None if operator is None else operator.client.client_id


def tab_of(name: str) -> str:
    return f"{name.encode().hex():0<32}"


def sessions_of(host: LectureHost | BreakoutHost) -> dict[int, Session]:
    """Breakout sessions of a host by client id."""
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


def everything(visitor: BlockingClient) -> str:
    """All messages that a page has received; its client must come from the fixture `come`."""
    return html.unescape("\n".join(list(vars(visitor.mirror)["heard"])))


def choose(visitor: BlockingClient, label: str) -> None:
    """Press the button with this label in a row of buttons."""

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
    """Trigger a command by its name, as the palette and the keys do."""
    visitor.wait_for(lambda v: any(c["label"] == name for c in list(v.mirror.commands.values())), WAIT)
    uuid = next(uuid for uuid, c in list(visitor.mirror.commands.items()) if c["label"] == name)
    visitor.send({"type": "CommandTriggerMessage", "uuid": uuid})


def drawn_name(student: BlockingClient) -> str:
    found = re.search(r"For the teacher you are ([^.<]+)\.", shown(student))
    assert found is not None, shown(student)[-2000:]
    return found[1]


def leave_lessons(teacher: BlockingClient) -> None:
    click(teacher, "Leave the lessons")
    click(teacher, "Leave with the class")


def banner(visitor: BlockingClient) -> str:
    """Text of a page's banner, with … for the drawn name."""
    name = re.search(r"For the teacher you are ([^.<]+)\.", shown(visitor))
    said = "\n".join(re.findall(r'class="duet-banner[^>]*>([^<]*)<', shown(visitor))) + "\n"
    return said if name is None else said.replace(name[1], "…")


class Class:
    """A lecture with its teacher in lesson 1, and its students by name."""

    def __init__(self, house: OpenHouse, come: Come, **options: Any) -> None:
        self.opened, self._come = house(lecture=True, key=KEY, **options), come
        self.host = lecture_of(self.opened)
        self.teacher = come(self.opened, key=KEY)
        self.students: dict[str, BlockingClient] = {}
        open_lessons(self.teacher)
        sees(self.teacher, "Lesson 1 · step 1")

    def come(self, *names: str, query: str = "") -> list[BlockingClient]:
        self.students |= {name: self._come(self.opened, name, query=query) for name in names}
        return [self.students[name] for name in names]

    def screen(self, key: str = "") -> BlockingClient:
        """A projector."""
        return self._come(self.opened, query="screen=1", key=key)

    def send(self, label: str, *names: str) -> list[BlockingClient]:
        """Choose, as the teacher, where the students work; their pages reconnect as asked."""
        choose(self.teacher, label)
        for name in names:
            self.is_sent_away(name)
        return self.come(*names)

    def explore(self, *names: str) -> None:
        """Prepare breakout places, single or shared, for students who connect later."""

        def settle(_: Session) -> None:
            self.host.classroom.explore()
            self.host.classroom.settle(tuple(map(tab_of, names)), monotonic())

        ask(self.host.session, settle)

    def session_of(self, name: str) -> Session:
        return sessions_of(self.host)[self.number(name)]

    def is_sent_away(self, name: str) -> None:
        """Wait until a student's page is asked to reconnect."""
        assert ended(self.students[name])[0] == MOVED_CODE

    def number(self, name: str) -> int:
        """Number of a student's breakout session; waits for it."""
        visitor = self.students[name]
        visitor.wait_for(lambda v: bodies(v, "GuiSliderMessage"), WAIT)
        (owner,) = {str(node["owner"]) for node in list(visitor.mirror.nodes.values()) if node.get("owner")}
        visitor.wait_for(lambda _: int(owner) in sessions_of(self.host), WAIT)
        return int(owner)

    def critical_distance(self, name: str) -> float:
        return ask(self.session_of(name), lambda s: s.settings.run.law.critical_distance)
