"""The operator of a lecture: one tab has the controls, reserved for a while after it leaves."""

from dataclasses import dataclass

import pytest

from app.features.lecture.leader import Leader
from app.features.lecture.lecture import LectureHost
from app.page.panels.hotkeys import hotkeys
from app.session.session import Session
from app.settings import Settings
from app.start import App
from tests.app.conftest import Join, OpenHouse, ask
from tests.app.features.lecture.forgery import drag, press_everything_of, wait_until_all_has_come
from tests.app.features.lecture.lecture_room import lecture_of, operator_of
from tests.app.page.by_hand import WRIST
from tests.app.page.helpers import bodies, buttons, click, hotkey_uuid, open_lessons
from tests.blocking_client import BlockingClient

LEADER = f"resume={'1' * 32}"
LINK = f"/arms/right{WRIST}"
D_M = "critical distance d_m [mm]"


def has_controls(visitor: BlockingClient) -> bool:
    operated = {f"Gui{kind}Message" for kind in ("Slider", "Dropdown", "Checkbox", "Number", "ButtonGroup")}
    return bool(
        operated & {element["type"] for element in list(visitor.mirror.gui.values())}
        or visitor.mirror.commands
        or visitor.mirror.grabbable
    )


@dataclass(frozen=True)
class Led:
    """A lecture without a key, its first tab and a second tab."""

    opened: App
    host: LectureHost
    first: BlockingClient
    second: BlockingClient

    @property
    def session(self) -> Session:
        return self.host.session


def leads(visitor: BlockingClient) -> None:
    """Wait until a page has all controls of an operator."""
    visitor.wait_for(lambda v: LINK in v.mirror.grabbable and len(v.mirror.commands) >= len(hotkeys()))


def pause(visitor: BlockingClient, session: Session) -> None:
    visitor.send({"type": "CommandTriggerMessage", "uuid": hotkey_uuid(visitor, "pause")})
    visitor.wait_for(lambda _: session.paused)


def set_critical_distance(visitor: BlockingClient, session: Session, millimetres: float) -> None:
    visitor.set_value(D_M, millimetres)
    visitor.wait_for(lambda _: session.settings.run.law.critical_distance == millimetres / 1000.0)


@pytest.fixture
def led(house: OpenHouse, join: Join) -> Led:
    opened = house(lecture=True)
    first = join(opened, LEADER)
    leads(first)
    return Led(opened, lecture_of(opened), first, join(opened, "dm=0.3"))


def test_all_see_the_same_run_and_the_first_tab_operates_it(led: Led) -> None:
    assert led.session.settings == Settings(), "a watcher's link changes nothing"
    for visitor in (led.first, led.second):
        visitor.wait_for(lambda v: len(bodies(v, "GuiUplotMessage")) == 2)
    pause(led.first, led.session)
    set_critical_distance(led.first, led.session, 50.0)
    assert has_controls(led.first) and not has_controls(led.second)
    assert operator_of(led.host) == int(led.first.mirror.nodes[LINK]["owner"])


def test_forged_messages_of_a_watcher_change_nothing(led: Led) -> None:
    host, first, second = led.host, led.first, led.second
    pause(first, led.session)
    open_lessons(first)
    first.wait_for(lambda v: "Run (predict first)" in buttons(v))

    def state(s: Session) -> tuple[object, ...]:
        classroom, walk = host.classroom, host.lessons.walk
        run = s.settings, s.paused, s.held, s.simulation.steps
        return *run, classroom.free, classroom.paused, host.lessons.open, walk.to_json()

    before, operator = ask(led.session, state), operator_of(host)
    assert operator is not None
    for owner in (str(operator), "", str(operator + 1)):
        drag(second, LINK, owner)
    press_everything_of(first, second)
    wait_until_all_has_come(led.opened, second)
    assert ask(led.session, state) == before
    # The operator can.
    click(first, "Leave the lessons")
    click(first, "Leave with the class")
    first.wait_for(lambda _: not host.lessons.open)


def test_an_operator_who_leaves_during_a_drag_releases_the_hand(led: Led, join: Join) -> None:
    led.first.pull(LINK, "start", [0.3, 0.0, 1.0], [0.3, 0.0, 1.1])
    led.first.wait_for(lambda _: led.session.held is not None)
    led.first.close()
    led.second.wait_for(lambda _: led.host.controls.operator is None)
    third = join(led.opened, f"resume={'3' * 32}")
    third.wait_for(lambda _: len(led.host.classroom.here) == 2)
    assert led.host.controls.operator is None and led.session.held is None
    assert not has_controls(led.second) and not has_controls(third)


def test_the_first_tab_gets_the_controls_again_when_it_reconnects(led: Led, join: Join) -> None:
    operator = operator_of(led.host)
    led.first.close()
    led.second.wait_for(lambda _: led.host.controls.operator is None)
    again = join(led.opened, LEADER)
    leads(again)
    # The same before the server notices the next lost connection.
    back = join(led.opened, LEADER)
    leads(back)
    assert operator_of(led.host) == int(back.mirror.nodes[LINK]["owner"]) != operator
    set_critical_distance(back, led.session, 70.0)
    pause(back, led.session)
    assert not has_controls(led.second)


def test_without_a_key_the_lead_is_reserved_for_a_minute() -> None:
    now = 0.0
    lead, (ann, bo, cy, *others) = (
        Leader(None, clock=lambda: now),
        ({"resume": letter * 32} for letter in "abcde"),
    )

    def admits(client_id: int, query: dict[str, str], at: float) -> bool:
        nonlocal now
        now = at
        return lead.admits(client_id, query)

    assert not admits(1, ann | {"screen": "1"}, 0.0)
    assert admits(2, ann, 0.0) and not admits(3, bo, 1.0) and lead.holds(2) and not lead.holds(3)
    # A reload: the new connection starts before the old one ends.
    assert admits(4, ann, 10.0)
    lead.gone(2)
    assert lead.holds(4) and not admits(5, others[0], 80.0)
    now = 100.0
    lead.gone(4)
    assert not admits(6, bo, 101.0) and not admits(7, others[1], 159.0)
    # After the minute, former students and tabs without an id are students; a new tab leads.
    assert not any(admits(8, one, 161.0) for one in (bo, *others, {}))
    assert admits(9, cy, 162.0) and not admits(10, ann, 163.0)
