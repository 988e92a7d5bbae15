"""A lecture: all see the same, and one tab has the controls."""

from app.bench.headless_client import CAMERA
from app.classroom.leader import Leader
from app.hosting.teacher_key import MOST_ADDRESSES, Guesses
from app.page.panels.hotkeys import HOTKEYS
from app.session.session import Session
from app.settings import Settings
from app.web.index_page import KEY_LATER
from tests.app.conftest import Join, OpenHouse, ask, lecture_of
from tests.app.page.by_hand import WRIST
from tests.app.page.helpers import bodies, buttons, click, hotkey_uuid, open_lessons
from tests.blocking_client import BlockingClient

LEADER = f"resume={'1' * 32}"
LINK = f"/arms/right{WRIST}"


def has_controls(visitor: BlockingClient) -> bool:
    operated = {f"Gui{kind}Message" for kind in ("Slider", "Dropdown", "Checkbox", "Number", "ButtonGroup")}
    return bool(
        operated & {element["type"] for element in list(visitor.mirror.gui.values())}
        or visitor.mirror.commands
        or visitor.mirror.grabbable
    )


def test_a_lecture_shows_all_the_same_and_obeys_one(house: OpenHouse, join: Join) -> None:
    opened = house(lecture=True)
    host, session = lecture_of(opened), lecture_of(opened).session
    first = join(opened, LEADER)
    first.wait_for(lambda v: len(v.mirror.commands) >= len(HOTKEYS) and LINK in v.mirror.grabbable)
    second = join(opened, "dm=0.3")
    assert session.settings == Settings()
    for visitor in (first, second):
        visitor.wait_for(lambda v: len(bodies(v, "GuiUplotMessage")) == 2)
    first.send({"type": "CommandTriggerMessage", "uuid": hotkey_uuid(first, "pause")})
    first.wait_for(lambda _: session.paused)
    assert has_controls(first) and not has_controls(second)
    assert host.operator == int(first.mirror.nodes[LINK]["owner"])

    # The second one knows all the names, and it is of no use.
    open_lessons(first)
    first.wait_for(lambda v: "Run (predict first)" in buttons(v))

    def state(s: Session) -> tuple[object, ...]:
        room, lessons = host.room, host.lessons
        return s.settings, s.paused, s.held, s.simulation.steps, room.free, room.paused, lessons.open, lessons.walk.to_json()

    before, elements = ask(session, state), list(first.mirror.gui.values())
    for owner in (str(host.operator), "", str(int(host.operator or 0) + 1)):
        target = {"type": "SceneNodeDragMessage", "name": LINK, "owner": owner, "instance_index": None, "button": "left"}
        places = {"start_position": [0.3, 0.0, 1.0], "end_position": [0.0, 0.0, 1.0], "modifier": None}
        for phase in ("start", "update", "end"):
            second.send({**target, **places, "phase": phase, "start_screen_pos": [0.5, 0.5], "end_screen_pos": [0.5, 0.5]})
    values = {
        "GuiSliderMessage": [50.0],
        "GuiButtonGroupMessage": ["Reset", "Reset step", "Explore freely"],
        "GuiButtonMessage": [True],
    }
    for uuid, value in ((e["uuid"], value) for e in elements for value in values.get(e["type"], [])):
        second.send({"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": value}})
    for uuid in list(first.mirror.commands):
        second.send({"type": "CommandTriggerMessage", "uuid": uuid})
    # The camera is everybody's own: once it has arrived, all of the above has, too.
    known = opened.server.get_clients()
    (own,) = (client for number, client in known.items() if number != host.operator)
    second.send(CAMERA | {"image_height": 500, "image_width": 700})
    second.wait_for(lambda _: own.camera.image_width == 700)
    assert ask(session, state) == before
    # The first one can.
    click(first, "Leave the lessons")
    click(first, "Leave with the class")
    first.wait_for(lambda v: LINK in v.mirror.grabbable)
    first.set_value("critical distance d_m [mm]", 50.0)
    first.wait_for(lambda _: session.settings.run.law.critical_distance == 0.05)

    # It leaves in mid-drag: the hand is let go, and neither who is there nor who comes now takes over.
    first.pull(LINK, "start", [0.3, 0.0, 1.0], [0.3, 0.0, 1.1])
    first.wait_for(lambda _: session.held is not None)
    operator = host.operator
    first.close()
    second.wait_for(lambda _: host.operator is None)
    third = join(opened, f"resume={'3' * 32}")
    third.wait_for(lambda _: len(host.room.here) == 2)
    assert host.operator is None and session.held is None and not has_controls(second) and not has_controls(third)
    # It is back, before its next connection breaks off is noticed, too.
    again = join(opened, LEADER)
    again.wait_for(lambda v: LINK in v.mirror.grabbable and len(v.mirror.commands) >= len(HOTKEYS))
    back = join(opened, LEADER)
    back.wait_for(lambda v: LINK in v.mirror.grabbable and len(v.mirror.commands) >= len(HOTKEYS))
    assert host.operator == int(back.mirror.nodes[LINK]["owner"]) != operator
    back.set_value("critical distance d_m [mm]", 100.0)
    back.send({"type": "CommandTriggerMessage", "uuid": hotkey_uuid(back, "pause")})
    back.wait_for(lambda _: session.settings.run.law.critical_distance == 0.1 and session.paused)
    assert not has_controls(second) and not has_controls(third)


def test_without_a_key_the_lead_is_kept_for_a_minute_and_is_no_students() -> None:
    now = 0.0
    lead, (ann, bo, cy, *others) = Leader(None, lambda: now), ({"resume": letter * 32} for letter in "abcde")

    def admits(client_id: int, query: dict[str, str], at: float) -> bool:
        nonlocal now
        now = at
        return lead.admits(client_id, query)

    assert not admits(1, ann | {"screen": "1"}, 0.0)
    assert admits(2, ann, 0.0) and not admits(3, bo, 1.0) and lead.holds(2) and not lead.holds(3)
    # A reload: the new connection is there before the old one has gone.
    assert admits(4, ann, 10.0)
    lead.gone(2)
    assert lead.holds(4) and not admits(5, others[0], 80.0)
    now = 100.0
    lead.gone(4)
    assert not admits(6, bo, 101.0) and not admits(7, others[1], 159.0)
    # After the minute those who were in the class, or have no id, come back as students; a new tab leads.
    assert not any(admits(8, one, 161.0) for one in (bo, *others, {}))
    assert admits(9, cy, 162.0) and not admits(10, ann, 163.0)


def test_one_wrong_key_a_second_is_checked_from_one_address() -> None:
    now, wrong, right = 0.0, {"key": "chalk"}, {"key": "chalk-dust"}
    guesses, keyless = (Guesses(key, lambda: now) for key in ("chalk-dust", None))
    for now, address, query, answer in (  # noqa: B007  the clock reads it
        (5.0, "here", wrong, ""),
        (5.9, "here", wrong, KEY_LATER),
        (5.9, "here", right, KEY_LATER),
        (5.9, "here", {}, ""),
        (5.9, "there", right, ""),
        (6.1, "here", right, ""),
        (6.2, "here", right, ""),
    ):
        assert guesses.turn_away(address, query) == answer
        assert keyless.turn_away(address, query) == ""
    for i in range(MOST_ADDRESSES + 5):
        guesses.turn_away(f"{i}", wrong)
    assert len(guesses._wrong) == MOST_ADDRESSES
