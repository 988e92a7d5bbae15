"""A lecture: all see the same, whoever has the controls operates it, and there are more than eight seats."""

from __future__ import annotations

from urllib.parse import quote

from app.hosts import House
from app.lecture import LectureHost
from app.page.keys import HOTKEYS
from app.session import Session
from app.settings import Settings
from app.visitor.sync_visitor import SyncVisitor
from app.visitor.visitor import CAMERA
from tests.app.conftest import ELBOW, HAND, Join, OpenHouse, ask
from tests.app.page.helpers import bodies, hotkey_uuid


def lecture(opened: House) -> tuple[LectureHost, Session]:
    """The host and the session of a lecture."""
    assert isinstance(opened.host, LectureHost)
    return opened.host, opened.host.session


def arms(visitor: SyncVisitor) -> dict[str, tuple[float, ...]]:
    """How every link is turned on a visitor's page."""
    return {name: tuple(node["wxyz"]) for name, node in list(visitor.mirror.nodes.items()) if name.startswith("/arms/")}


def has_controls(visitor: SyncVisitor) -> bool:
    """Whether a visitor has anything to operate."""
    operated = {"GuiSliderMessage", "GuiDropdownMessage", "GuiCheckboxMessage", "GuiNumberMessage", "GuiButtonGroupMessage"}
    there_are = {element["type"] for element in list(visitor.mirror.gui.values())}
    return bool(operated & there_are or visitor.mirror.commands or {HAND, ELBOW} & set(visitor.mirror.nodes))


def test_a_lecture_shows_all_the_same_and_obeys_one(house: OpenHouse, join: Join) -> None:
    opened = house(lecture=True)
    host, session = lecture(opened)
    first = join(opened)
    first.wait_for(lambda v: len(v.mirror.commands) >= len(HOTKEYS) and HAND in v.mirror.nodes)
    second = join(opened, "dm=0.3")
    assert session.settings == Settings()
    for visitor in (first, second):
        visitor.wait_for(lambda v: sum(e["type"] == "GuiUplotMessage" for e in v.mirror.gui.values()) == 2)
    # Stop, so that the poses can be compared.
    first.wait_for(lambda _: session.simulation.steps > 0)
    first.send({"type": "CommandTriggerMessage", "uuid": hotkey_uuid(first, "pause")})
    first.wait_for(lambda _: session.paused)
    steps = ask(session, lambda s: s.simulation.steps)
    second.wait_for(lambda _: arms(second) == arms(first))
    assert steps > 0 and len(arms(first)) == 18
    assert has_controls(first) and not has_controls(second)
    assert host.operator == int(first.mirror.nodes[HAND]["owner"])

    # The second one knows all the names, and it is of no use.
    before = session.settings
    slider, group = first.mirror.labelled("d_m [mm]")["uuid"], bodies(first, "GuiButtonGroupMessage")[0]["uuid"]
    for owner in (str(host.operator), "", str(int(host.operator or 0) + 1)):
        target = {"name": HAND, "owner": owner}
        second.send({"type": "TransformControlsDragStartMessage", **target})
        second.send(
            {"type": "TransformControlsUpdateMessage", **target, "position": [0.0, 0.0, 1.0], "wxyz": [1.0, 0.0, 0.0, 0.0]}
        )
        second.send({"type": "TransformControlsDragEndMessage", **target})
    second.send({"type": "GuiUpdateMessage", "uuid": slider, "updates": {"value": 50.0}})
    second.send({"type": "GuiUpdateMessage", "uuid": group, "updates": {"value": "Reset"}})
    for action in ("pause", "reset", "law"):
        second.send({"type": "CommandTriggerMessage", "uuid": hotkey_uuid(first, action)})
    # The camera is everybody's own: once it has arrived, all of the above has, too.
    known = opened.server.get_clients()
    (own,) = (client for number, client in known.items() if number != host.operator)
    second.send(CAMERA | {"image_height": 500, "image_width": 700})
    second.wait_for(lambda _: own.camera.image_width == 700)
    assert ask(session, lambda s: (s.settings, s.paused, s.held, s.simulation.steps)) == (before, True, None, steps)
    # The first one can.
    first.set_value("d_m [mm]", 50.0)
    first.wait_for(lambda _: session.settings.run.law.critical_distance == 0.05)

    # It leaves in mid-drag: the second one takes over, and the hand is let go.
    first.move_gizmo(HAND, phase="start")
    first.wait_for(lambda _: session.held is not None)
    operator = host.operator
    first.close()
    second.wait_for(lambda v: HAND in v.mirror.nodes and len(v.mirror.commands) >= len(HOTKEYS))
    assert host.operator not in (None, operator) and session.held is None
    second.wait_for(lambda _: has_controls(second))
    second.set_value("d_m [mm]", 100.0)
    second.send({"type": "CommandTriggerMessage", "uuid": hotkey_uuid(second, "pause")})
    second.wait_for(lambda _: session.settings.run.law.critical_distance == 0.1 and not session.paused)


def test_with_a_key_only_its_holder_has_the_controls(house: OpenHouse, join: Join) -> None:
    opened = house(lecture=True, key="chalk ü")
    host, session = lecture(opened)
    pupils = [join(opened, query) for query in ("", "key=", "key=chal", f"KEY={quote('chalk ü')}", "key=" + "x" * 300)]
    pupils[0].wait_for(lambda _: session.simulation.time > 0.3)
    assert host.operator is None
    teacher = join(opened, f"key={quote('chalk ü')}")
    teacher.wait_for(lambda v: HAND in v.mirror.nodes)
    assert has_controls(teacher) and not any(has_controls(pupil) for pupil in pupils)
    # The key is the lecturer's: it must not be on anybody's page.
    assert all("chalk" not in repr((pupil.mirror.gui, pupil.mirror.nodes)) for pupil in (*pupils, teacher))
    teacher.close()
    pupils[0].wait_for(lambda _: host.operator is None)
    until = session.simulation.time + 0.3
    pupils[0].wait_for(lambda _: session.simulation.time > until)
    assert host.operator is None and not any(has_controls(pupil) for pupil in pupils)
    again = join(opened, f"key={quote('chalk ü')}")
    again.wait_for(lambda v: HAND in v.mirror.nodes)


def test_a_lecture_has_more_than_eight_seats(house: OpenHouse, join: Join) -> None:
    opened = house(lecture=True)
    crowd = [join(opened, query=f"resume={number:016d}") for number in range(12)]
    crowd[-1].wait_for(lambda v: v.received.frames > 20)
    assert all(visitor.closed is None for visitor in crowd) and opened.server.count_clients() == 12
