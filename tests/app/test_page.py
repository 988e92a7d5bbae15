"""The page on the server's side: visitors who speak viser's protocol operate every control, well and badly.

Every "nothing happens" is followed, on the same connection, by something that does happen: messages are read in order, so by then
the others have been dealt with.
"""

from __future__ import annotations

import gc
import html
import math
import os
import threading
import time
import urllib.error
import urllib.request
from typing import Any
from urllib.parse import quote

import numpy as np
import pinocchio as pin
import pytest
import websockets

from app.hosts import House, LectureHost
from app.index import ROOM_IS_FULL
from app.page.controls import PICKER, TABS
from app.page.gizmos import NUDGE, SWING, swivel_frame
from app.page.keys import HOTKEYS
from app.page.plots import POINTS, WINDOW, PlotBuffer
from app.page.relevance import matters
from app.session import Session
from app.settings import Settings
from app.wsclient import CAMERA, SyncVisitor, Visitor
from scenes.autopilot import Autopilot
from scenes.history import COLUMN
from scenes.settings import RunSettings, changed, specs, values
from scenes.simulation import Simulation
from scenes.targets import HandTarget
from tests.app.conftest import ELBOW, HAND, Arrive, Guest, Join, OpenHouse, ask, live_sessions

SPECS = specs(Settings)
ON_PAGE = (*PICKER, *(key for _, _, keys in TABS for key in keys))
USUAL_STAGE = {"scene": "hold", "law": "smooth_priority"}
STAGES: dict[str, dict[str, str]] = {
    **{key: {"scene": "solo"} for key in ("path", "kx")},
    **{key: {"scene": "ball"} for key in ("point", "ball")},
    **{key: {"scene": "imitation", "source": "clips"} for key in ("source", "clip")},
    "following": {"scene": "master_slave"},
    **{key: {"law": "potential_field"} for key in ("d0", "eta")},
    "gamma": {"law": "barrier_qp"},
    "beta": {"pairs": "soft"},
    "coupled": {"avoid": "both"},
}
"""Key → what must be chosen for its control to be in view; the others are there by default."""
NAN, INF = math.nan, math.inf
MARK = "● "


def page_label(key: str) -> str:
    """What stands before a control."""
    spec = SPECS[key]
    return f"{spec.label} [{spec.page_unit}]" if spec.page_unit else spec.label


def bring_into_view(session: Session, key: str) -> None:
    """Choose an experiment and a law in which a setting matters."""

    def choose(s: Session) -> None:
        for k, value in (USUAL_STAGE | STAGES.get(key, {})).items():
            s.change(k, value)

    if not matters(key, session.settings):
        ask(session, choose)
    assert matters(key, session.settings), key


def another(key: str, present: Any) -> tuple[Any, Any]:
    """A possible value other than the present one: as the page sends it, and as the settings keep it."""
    spec = SPECS[key]
    if spec.choices:
        index = (spec.choices.index(present) + 1) % len(spec.choices)
        return spec.choice_labels[index], spec.choices[index]
    if isinstance(present, bool):
        return not present, not present
    if isinstance(present, int):
        return present + 41, present + 41
    page = spec.low * spec.page_scale + 3.0 * spec.step
    if abs(page / spec.page_scale - present) < 1e-9:
        page += spec.step
    return page, page / spec.page_scale


def hotkey_uuid(visitor: SyncVisitor, action: str) -> str:
    """The uuid of the palette command that stands for a hotkey."""
    text = next(h.text for h in HOTKEYS if h.action == action).capitalize()
    return next(uuid for uuid, command in visitor.mirror.commands.items() if command["label"] == text)


def press(guest: Guest, action: str) -> None:
    """Press a hotkey, and wait until it has been acted upon."""
    guest.visitor.send({"type": "CommandTriggerMessage", "uuid": hotkey_uuid(guest.visitor, action)})
    roundtrip(guest)


def roundtrip(guest: Guest) -> None:
    """Return when the server has acted upon all that the visitor said before."""
    before = guest.session.settings.run.limit_gain
    value = before + 0.5 if before < 20.0 else before - 5.5
    guest.visitor.set_value("g [1/s]", value)
    guest.wait(lambda s: abs(s.settings.run.limit_gain - value) < 1e-9)


def bodies(visitor: SyncVisitor, kind: str) -> list[dict[str, Any]]:
    """The GUI elements of a kind that are not hidden, in the order they came."""
    elements = list(visitor.mirror.gui.values())
    return [element for element in elements if element["type"] == kind and element.get("visible", True)]


def notes(visitor: SyncVisitor) -> list[str]:
    """What the notifications say."""
    return [str(note["body"]) for note in bodies(visitor, "NotificationShowMessage")]


def assert_sound(guest: Guest) -> None:
    """The arms are and were where arms can be, and every setting is in its range."""
    table, simulation = guest.ask(lambda s: s.simulation.history.table()), guest.session.simulation
    q, model = simulation.history.positions(table), simulation.room.model
    assert len(q) and np.isfinite(q).all()
    assert (q >= model.lowerPositionLimit - 1e-9).all() and (q <= model.upperPositionLimit + 1e-9).all()
    settings = guest.session.settings
    for key, value in values(settings).items():
        assert changed(settings, key, value) == settings and type(value) is type(values(Settings())[key]), key


# --- controls ------------------------------------------------------------------------------------------------------------------


def test_every_setting_has_its_place() -> None:
    assert sorted(ON_PAGE) == sorted(set(SPECS) - {"speed", "plot"})


def test_every_control_changes_one_setting_of_one_visitor(house: OpenHouse, arrive: Arrive) -> None:
    opened = house()
    one, other = arrive(opened), arrive(opened, "autopilot=0&dm=0.12")
    theirs = values(other.session.settings)
    for key in ON_PAGE:
        bring_into_view(one.session, key)
        one.visitor.wait_for(lambda v, key=key: v.mirror.labelled(page_label(key))["visible"])
        before = values(one.session.settings)
        sent, expected = another(key, before[key])
        one.visitor.set_value(page_label(key), sent)
        one.wait(lambda s, key=key, expected=expected: values(s.settings)[key] == pytest.approx(expected, abs=1e-9))
        after = values(one.session.settings)
        assert {k for k in after if after[k] != before[k]} == {key}
        assert one.session.simulation.settings == one.session.settings.run
        assert values(other.session.settings) == theirs, key
        if key in PICKER:
            one.run_on(0.05)
            assert_sound(one)
    ask(one.session, lambda s: s.change("scene", "hold"))
    one.run_on(0.3)
    other.run_on(0.3)
    assert_sound(one)
    assert one.session.simulation.room.rig.name == "table" and other.session.simulation.room.rig.name == "torso"
    # And the buttons: transport, speed, third plot.
    transport, speed, more = (one.visitor.mirror.labelled(label) for label in ("clock", "speed", "more plots"))
    for group, label in ((speed, "½×"), (more, "λ"), (transport, "Pause")):
        one.visitor.send({"type": "GuiUpdateMessage", "uuid": group["uuid"], "updates": {"value": label}})
    one.wait(lambda s: s.paused and s.settings.page.speed == 0.5 and s.settings.page.details == "lambda")
    one.visitor.wait_for(lambda _: f"{MARK}Pause" in transport["options"] and f"{MARK}½×" in speed["options"])
    one.visitor.wait_for(lambda _: f"{MARK}λ" in more["options"] and len(bodies(one.visitor, "GuiUplotMessage")) == 3)
    assert not other.session.paused and values(other.session.settings) == theirs


def test_two_visitors_live_apart(house: OpenHouse, arrive: Arrive) -> None:
    """What one does leaves the other's arms where they would have been anyway, to the last bit."""
    opened = house()
    one, other = arrive(opened), arrive(opened, "seed=5&guided=left")
    for key in ("law", "dm", "n", "v", "rig"):
        one.visitor.set_value(page_label(key), another(key, values(one.session.settings)[key])[0])
        one.run_on(0.1)
    table, settings = other.ask(lambda s: (s.simulation.history.table(), s.settings))
    alone = Session(settings)
    while alone.simulation.steps < len(table):
        alone.advance(alone.settings.run.dt)
    assert len(table) > 50
    assert alone.simulation.history.table().tobytes() == table.tobytes()


@pytest.mark.parametrize("key", ON_PAGE)
def test_no_value_from_outside_gets_in(house: OpenHouse, arrive: Arrive, key: str) -> None:
    one = arrive(house())
    bring_into_view(one.session, key)
    before = values(one.session.settings)
    label, spec = page_label(key), SPECS[key]
    if spec.choices:
        bad: list[Any] = ["nonsense", "", spec.choices[0], "x" * 5000]
    elif isinstance(before[key], bool):
        bad = []
    else:
        high = spec.high * spec.page_scale
        bad = [NAN, INF, -INF, 1e9, -1e9, 1e308, spec.low * spec.page_scale - spec.step, high + spec.step]
        bad += [] if isinstance(before[key], int) else [high * (1.0 + 1e-7)]
    for value in bad:
        one.visitor.set_value(label, value)
    roundtrip(one)
    if key != "g":
        after = values(one.session.settings)
        assert {k for k in after if after[k] != before[k]} == {"g"}
    sent, expected = another(key, before[key])
    one.visitor.set_value(label, sent)
    one.wait(lambda s: values(s.settings)[key] == pytest.approx(expected, abs=1e-9))
    one.run_on(0.05)
    assert_sound(one)


def test_wrong_types_cost_only_the_own_connection(house: OpenHouse, arrive: Arrive) -> None:
    opened = house()
    witness = arrive(opened)
    before = values(witness.session.settings)
    for key in ON_PAGE:
        wrong: list[Any] = [None, [1, 2], {"a": 1}, b"\x00", 3 if SPECS[key].choices or isinstance(before[key], bool) else "wide"]
        for value in wrong[hash_free_index(key) % 5 :: 5]:
            victim = arrive(opened)
            victim.visitor.set_value(page_label(key), value)
            victim.visitor.wait_for(lambda v: v.closed)
            assert victim.visitor.closed is not None and victim.visitor.closed.rcvd is not None
            assert victim.visitor.closed.rcvd.code == 1008
            assert values(victim.session.settings) == before
            witness.wait(lambda _, number=victim.number: number not in live_sessions(opened))
    witness.run_on(0.1)
    assert values(witness.session.settings) == before and set(live_sessions(opened)) == {witness.number}
    assert_sound(witness)


def hash_free_index(key: str) -> int:
    """A number for a key that is the same in every run."""
    return ON_PAGE.index(key)


def test_a_refused_value_is_named_and_written_back(house: OpenHouse, arrive: Arrive) -> None:
    one = arrive(house())
    # A hair over the edge: near enough for the door, which leaves room for a browser's rounding, but not for the settings.
    one.visitor.set_value("d_m [mm]", 300.0 * (1.0 + 5e-7))
    one.visitor.wait_for(lambda _: any("dm = 0.3" in note for note in notes(one.visitor)))
    one.visitor.wait_for(lambda v: v.mirror.labelled("d_m [mm]")["value"] == 150.0)
    assert one.session.settings.run.law.critical_distance == 0.15
    one.visitor.set_value("d_m [mm]", 300.0)
    one.wait(lambda s: s.settings.run.law.critical_distance == 0.3)


# --- the handles ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", [HAND, ELBOW])
def test_odd_poses_of_a_handle(house: OpenHouse, arrive: Arrive, name: str) -> None:
    opened = house()
    one, witness = arrive(opened), arrive(opened)
    one.visitor.move_gizmo(name, phase="start")
    one.wait(lambda s: not s.settings.page.autopilot)
    turn = (0.5, 0.5, 0.5, 0.5)
    for position, wxyz in (
        ((NAN, 0.0, 1.0), turn),
        ((0.3, INF, 1.0), turn),
        ((0.3, 0.0, -INF), turn),
        ((1e308, 0.0, 1.0), turn),
        ((0.3, 0.0, 1.0), (0.0, 0.0, 0.0, 0.0)),
        ((0.3, 0.0, 1.0), (NAN, 0.0, 0.0, 1.0)),
        ((0.3, 0.0, 1.0), (1e6, 0.0, 0.0, 1.0)),
        ((1e8, -1e8, 1e8), turn),
        ((-1e8, 1e8, -1e8), (0.9, 0.9, 0.9, 0.9)),
        ((0.0, 0.0, 0.92), (-1.0, 0.0, 0.0, 0.0)),
    ):
        one.visitor.move_gizmo(name, position, wxyz)
        roundtrip(one)
        one.run_on(0.1)
        held = one.ask(lambda s: s.held)
        assert isinstance(held, HandTarget) and np.isfinite(held.position).all() and np.abs(held.position).max() <= 2.5
        assert held.rotation is not None and np.allclose(held.rotation @ held.rotation.T, np.eye(3))
    assert_sound(one)
    assert one.session.held is not None
    one.visitor.move_gizmo(name, phase="end")
    one.wait(lambda s: s.held is None)
    for position, wxyz in (((1.0, 2.0), turn), ("here", turn), ((0.0, 0.0, 1.0), (1.0, 0.0)), (None, None), ((True, 0, 0), turn)):
        victim = arrive(opened)
        victim.visitor.move_gizmo(name, position, wxyz)
        victim.visitor.wait_for(lambda v: v.closed)
        assert victim.session.held is None
        witness.wait(lambda _, number=victim.number: number not in live_sessions(opened))
    witness.run_on(0.05)
    assert witness.session.settings == Settings() and witness.session.held is None


def test_dragging_the_hand(house: OpenHouse, arrive: Arrive) -> None:
    one = arrive(house(), "speed=2")
    visitor, session = one.visitor, one.session
    one.run_on(0.2)
    assert session.settings.page.autopilot

    def start(s: Session) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        k = s.simulation.kinematics
        hand = k.hand_pose(s.simulation.guided).translation.copy()
        return hand, k.hand_pose(s.simulation.avoiding).translation.copy(), s.simulation.positions.copy()

    visitor.move_gizmo(HAND, phase="start")
    one.wait(lambda s: not s.settings.page.autopilot and s.held is not None)
    hand, other_hand, q = one.ask(start)
    turn = visitor.mirror.nodes[HAND]["wxyz"]
    shown = [tuple(visitor.mirror.nodes[HAND]["position"])]
    # Further, and the orange arm is at the end of its own joints.
    goal = hand + (other_hand - hand) * 0.75
    for share in np.linspace(0.1, 1.0, 10):
        visitor.move_gizmo(HAND, tuple((hand + (goal - hand) * share).tolist()), turn)
        one.run_on(0.25)
        shown.append(tuple(visitor.mirror.nodes[HAND]["position"]))
    # It came.
    nearest = lambda s: float(np.linalg.norm(s.simulation.kinematics.hand_pose(s.simulation.guided).translation - goal))  # noqa: E731
    one.wait(lambda s: nearest(s) < 5e-3, 30.0)
    # While it is held, the server leaves the handle alone.
    assert len(set(shown)) == 1
    # The other arm yielded, and no closer than d_m.
    table = one.ask(lambda s: s.simulation.history.table())
    simulation = session.simulation
    moved = simulation.history.positions(table)[-1][simulation.avoiding.joints] - q[simulation.avoiding.joints]
    assert np.abs(moved).max() > 0.1
    assert table[:, COLUMN["d"]].min() >= session.settings.run.law.critical_distance - 1e-4
    assert table[:, COLUMN["d"]].min() < session.settings.run.law.critical_distance + 0.05
    assert table[:, COLUMN["w"]].max() <= session.settings.run.hand_speed + 1e-9
    # Let go: the handle sits on the hand again.
    visitor.move_gizmo(HAND, phase="end")
    one.wait(lambda s: s.held is None)

    def on_hand(_: Visitor) -> bool:
        pose = session.simulation.kinematics.hand_pose(session.simulation.guided)
        return bool(np.linalg.norm(np.array(visitor.mirror.nodes[HAND]["position"]) - pose.translation) < 1e-3)

    visitor.wait_for(on_hand)
    assert visitor.mirror.nodes[HAND]["position"] != shown[0] and not session.settings.page.autopilot
    assert_sound(one)


def test_turning_the_hand(house: OpenHouse, arrive: Arrive) -> None:
    one = arrive(house(), "autopilot=0")
    pose = one.ask(lambda s: s.simulation.kinematics.hand_pose(s.simulation.guided).copy())
    wanted = pose.rotation @ pin.rpy.rpyToMatrix(0.0, 0.0, 0.4)
    q = pin.Quaternion(wanted)
    one.visitor.move_gizmo(HAND, phase="start")
    one.visitor.move_gizmo(HAND, tuple(pose.translation.tolist()), (q.w, q.x, q.y, q.z))

    def away(s: Session) -> float:
        present = s.simulation.kinematics.hand_pose(s.simulation.guided)
        assert np.linalg.norm(present.translation - pose.translation) < 5e-3
        return float(np.linalg.norm(pin.log3(wanted.T @ present.rotation)))

    assert one.ask(away) > 0.3
    while one.ask(away) > 0.02:
        one.run_on(0.1)
    one.visitor.move_gizmo(HAND, phase="end")
    one.wait(lambda s: s.held is None)


def test_dragging_the_elbow_swivels_it_and_leaves_the_hand(house: OpenHouse, arrive: Arrive) -> None:
    one = arrive(house(), "autopilot=0")
    visitor = one.visitor

    def state(s: Session) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        k, arm = s.simulation.kinematics, s.simulation.guided
        frame, foot = swivel_frame(s.simulation)
        return k.joint_point(arm.elbow).copy(), k.hand_pose(arm).translation.copy(), frame, foot

    elbow, hand, frame, foot = one.ask(state)
    visitor.move_gizmo(ELBOW, phase="start")
    for angle in np.linspace(0.05, 0.4, 8):
        q = pin.Quaternion(frame @ pin.rpy.rpyToMatrix(float(angle), 0.0, 0.0))
        visitor.move_gizmo(ELBOW, tuple(elbow.tolist()), (q.w, q.x, q.y, q.z))
        one.run_on(0.1)
    goal = foot + pin.exp3(frame[:, 0] * 0.4) @ (elbow - foot)
    assert np.linalg.norm(goal - elbow) > 0.05
    now = elbow
    for _ in range(60):
        now, hand_now, _, _ = one.ask(state)
        assert np.linalg.norm(hand_now - hand) < 5e-3
        if np.linalg.norm(now - goal) < 0.01:
            break
        one.run_on(0.1)
    else:
        pytest.fail(f"the elbow is still {np.linalg.norm(now - goal):.3f} m from where it was swivelled to")
    visitor.move_gizmo(ELBOW, phase="end")
    one.wait(lambda s: s.held is None)
    visitor.wait_for(lambda v: np.linalg.norm(np.array(v.mirror.nodes[ELBOW]["position"]) - now) < 0.02)


def test_a_tab_closed_in_mid_drag(house: OpenHouse, arrive: Arrive) -> None:
    opened = house()
    leaver, witness = arrive(opened), arrive(opened)
    leaver.visitor.move_gizmo(HAND, phase="start")
    leaver.visitor.move_gizmo(HAND, (0.3, 0.0, 1.0))
    leaver.wait(lambda s: s.held is not None)
    leaver.visitor.close()
    witness.wait(lambda _: set(live_sessions(opened)) == {witness.number})
    witness.run_on(0.3)
    assert witness.session.settings.page.autopilot and witness.session.held is None
    assert len(opened.server.scene._active_transform_drag_handles) == 0


def test_a_reset_in_mid_drag_lets_go(house: OpenHouse, arrive: Arrive) -> None:
    one = arrive(house(), "autopilot=0")
    one.visitor.move_gizmo(HAND, phase="start")
    one.visitor.move_gizmo(HAND, (0.4, -0.1, 1.1))
    one.run_on(0.3)
    press(one, "reset")
    assert one.ask(lambda s: s.held is None)
    home = one.ask(lambda s: s.simulation.kinematics.hand_pose(s.simulation.guided).translation.copy())
    one.visitor.wait_for(lambda v: np.linalg.norm(np.array(v.mirror.nodes[HAND]["position"]) - home) < 1e-3)
    one.visitor.move_gizmo(HAND, (0.4, -0.1, 1.1))
    one.wait(lambda s: s.held is not None)


@pytest.mark.skipif(not os.path.isdir("/proc/self/fd"), reason="counts through /proc, which only Linux has")
def test_fifty_visits_leave_nothing_behind(house: OpenHouse, arrive: Arrive) -> None:
    opened = house()

    def visit(number: int) -> None:
        with SyncVisitor(opened.url, query=f"seed={number}") as visitor:
            visitor.wait_for(lambda v: HAND in v.mirror.nodes)
            if number % 3 == 0:
                visitor.move_gizmo(HAND, phase="start")

    def count() -> tuple[int, int, int]:
        gc.collect()
        sessions = sum(isinstance(thing, Session) for thing in gc.get_objects())
        return len(os.listdir("/proc/self/fd")), threading.active_count(), sessions

    def alone(_: Session) -> bool:
        return opened.server.count_clients() == 1 and set(live_sessions(opened)) == {witness.number}

    witness = arrive(opened)
    visit(0)
    witness.wait(alone)
    witness.run_on(0.05)
    before = count()
    for number in range(50):
        visit(number)
    witness.wait(alone)
    # Local variables of the frame loop may hold the last one until the next frame.
    witness.run_on(0.1)
    after = count()
    assert after[:2] == before[:2] and after[2] <= before[2] + 1
    assert_sound(witness)


# --- links ---------------------------------------------------------------------------------------------------------------------


def test_a_link_sets_the_start(house: OpenHouse, arrive: Arrive) -> None:
    opened = house()
    one = arrive(opened, "rig=table&law=unprotected&dm=0.1&n=10&theme=dark&plot=speeds&speed=0.5")
    expected = {"rig": "table", "law": "unprotected", "dm": 0.1, "n": 10.0, "theme": "dark", "plot": "speeds", "speed": 0.5}
    assert values(one.session.settings) == values(Settings()) | expected
    assert one.session.simulation.room.rig.name == "table"
    assert notes(one.visitor) == []
    # Controls and plots show it too; the last of them may still be on their way.
    mirror = one.visitor.mirror
    one.visitor.wait_for(lambda _: "colours" in {element.get("label") for element in list(mirror.gui.values())})
    assert mirror.labelled("d_m [mm]")["value"] == 100.0 and mirror.labelled("n")["value"] == 10.0
    assert mirror.labelled("law")["value"] == "Unprotected (task only)" and mirror.labelled("colours")["value"] == "Dark"
    assert len(bodies(one.visitor, "GuiUplotMessage")) == 3
    plain = arrive(opened)
    assert plain.session.settings == Settings()


def test_a_bad_part_of_a_link_is_named_and_the_rest_holds(house: OpenHouse, arrive: Arrive) -> None:
    one = arrive(house(), "rig=table&dm=9&law=strict&n=10&colour=red&v=nan&initialCameraFov=1&websocket=x&seed=1.5")
    assert values(one.session.settings) == values(Settings()) | {"rig": "table", "n": 10.0}
    one.visitor.wait_for(lambda _: len(notes(one.visitor)) >= 5)
    said = notes(one.visitor)
    for named in ("dm = '9'", "law = 'strict'", "'colour'", "v = 'nan'", "seed = '1.5'"):
        assert sum(named in note for note in said) == 1, (named, said)


MALICE = "<img src=x onerror=alert(1)>"


@pytest.mark.parametrize("query", [f"law={quote(MALICE)}", f"{quote(MALICE)}=1", f"seed={quote(MALICE)}"])
def test_a_links_text_is_only_ever_plain_text(house: OpenHouse, arrive: Arrive, query: str) -> None:
    one = arrive(house(), query)
    one.visitor.wait_for(lambda _: notes(one.visitor))
    # The browser shows a notification's text as text; nothing else may carry it.
    assert any(MALICE[:20] in note for note in notes(one.visitor))
    one.run_on(0.3)
    for element in list(one.visitor.mirror.gui.values()):
        if element["type"] != "NotificationShowMessage":
            assert "onerror" not in repr(element) and html.escape(MALICE) not in repr(element)
    assert "onerror" not in repr(one.visitor.mirror.nodes) and "onerror" not in repr(one.visitor.mirror.commands)


# --- places --------------------------------------------------------------------------------------------------------------------


def fetch(url: str) -> tuple[int, str]:
    """Status and text of a page."""
    try:
        with urllib.request.urlopen(url, timeout=5) as answer:
            return answer.status, answer.read().decode()
    except urllib.error.HTTPError as error:
        return error.code, error.read().decode()


def test_the_ninth_visitor_is_turned_away_kindly(house: OpenHouse, arrive: Arrive) -> None:
    opened = house()
    assert fetch(opened.url)[0] == 200
    guests = [arrive(opened) for _ in range(8)]
    status, text = fetch(opened.url)
    assert status == 503 and "Every place is taken" in text and "8 places" in text
    with SyncVisitor(opened.url) as ninth:
        ninth.wait_for(lambda v: v.closed)
        assert ninth.closed is not None and ninth.closed.rcvd is not None and ninth.closed.rcvd.reason == ROOM_IS_FULL
    for guest in guests:
        guest.run_on(0.02)
    guests[0].visitor.close()
    guests[1].wait(lambda _: opened.server.count_clients() == 7)
    assert fetch(opened.url)[0] == 200
    assert arrive(opened).number not in {guest.number for guest in guests}


# --- lectures ------------------------------------------------------------------------------------------------------------------


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
    crowd = [join(opened) for _ in range(12)]
    crowd[-1].wait_for(lambda v: v.received.frames > 20)
    assert all(visitor.closed is None for visitor in crowd) and opened.server.count_clients() == 12


# --- keys ----------------------------------------------------------------------------------------------------------------------


def test_every_hotkey_does_what_the_table_says(house: OpenHouse, arrive: Arrive) -> None:
    opened = house()
    one = arrive(opened)
    session, done = one.session, set[str]()

    def hit(action: str) -> None:
        done.add(action)
        press(one, action)

    hit("pause")
    assert session.paused
    steps = session.simulation.steps
    hit("step")
    one.wait(lambda s: s.simulation.steps == steps + 1)
    assert session.paused
    hit("slower")
    assert session.settings.page.speed == 0.5
    hit("faster")
    assert session.settings.page.speed == 1.0
    hit("law")
    assert session.settings.run.law.law == "unprotected"
    hit("law")
    assert session.settings.run.law.law == "smooth_priority"
    hit("autopilot")
    assert not session.settings.page.autopilot
    hit("autopilot")
    assert session.settings.page.autopilot
    (client,) = opened.server.get_clients().values()
    seen_from = tuple(client.camera.position)
    one.visitor.send(CAMERA | {"position": [0.0, 9.0, 9.0]})
    one.visitor.wait_for(lambda _: client.camera.position[1] == 9.0)
    cameras = one.visitor.received.messages["SetCameraPositionMessage"]
    hit("view")
    one.visitor.wait_for(lambda v: v.received.messages["SetCameraPositionMessage"] == cameras + 1)
    assert np.allclose(client.camera.position, seen_from)

    # Seen from in front of the torso, to the right is +y, away is −x (the view is turned by a little).
    place = one.ask(lambda s: s.simulation.kinematics.hand_pose(s.simulation.guided).translation.copy())
    ways = {"left": (0, -1, 0), "right": (0, 1, 0), "up": (0, 0, 1), "down": (0, 0, -1), "away": (-1, 0, 0), "near": (1, 0, 0)}
    for action, way in ways.items():
        hit(action)
        assert isinstance(session.held, HandTarget) and not session.settings.page.autopilot
        step = session.held.position - place
        assert np.linalg.norm(step) == pytest.approx(NUDGE, rel=1e-6)
        assert step @ np.array(way) > 0.9 * NUDGE, action
        assert way[2] or abs(step[2]) < 1e-9
        place = session.held.position.copy()
    elbow = one.ask(lambda s: s.simulation.kinematics.joint_point(s.simulation.guided.elbow))
    frame, foot = one.ask(lambda s: swivel_frame(s.simulation))
    for action, angle in (("elbow_up", SWING), ("elbow_down", 0.0), ("elbow_down", -SWING)):
        hit(action)
        assert isinstance(session.held, HandTarget) and session.held.elbow is not None
        assert np.allclose(session.held.elbow, foot + pin.exp3(frame[:, 0] * angle) @ (elbow - foot)), action
        assert np.allclose(session.held.position, place), "the hand stays where it was wanted"
    one.run_on(0.0)
    hit("reset")
    assert one.ask(lambda s: (s.simulation.steps, s.simulation.history.count, s.held)) == (0, 0, None)
    assert session.paused
    hit("pause")
    one.run_on(0.1)
    hit("ghost")
    assert session.settings.page.ghost == "frozen" and session.ghost is not None
    hit("ghost")
    assert session.settings.page.ghost == "off" and session.ghost is None
    for scene in SPECS["scene"].choices:
        hit(scene)
        assert session.simulation.settings.scene == scene
        one.run_on(0.05)
    assert done == {hotkey.action for hotkey in HOTKEYS}


def test_the_hotkeys_differ_from_each_other() -> None:
    assert len({(h.key, h.modifier) for h in HOTKEYS}) == len({h.shown for h in HOTKEYS}) == len(HOTKEYS)
    assert len({h.action for h in HOTKEYS}) == len({h.text for h in HOTKEYS}) == len(HOTKEYS)


# --- plots and traffic -----------------------------------------------------------------------------------------------------------


def plots(visitor: SyncVisitor) -> list[tuple[np.ndarray, ...]]:
    """The data of every plot, in order."""
    return [tuple(np.array(row) for row in element["data"]) for element in bodies(visitor, "GuiUplotMessage")]


def looks(visitor: SyncVisitor) -> list[tuple[Any, ...]]:
    """Colour and width of the first line of every plot, in order."""
    return [(element["series"][1]["stroke"], element["series"][1]["width"]) for element in bodies(visitor, "GuiUplotMessage")]


@pytest.mark.parametrize(("label", "value"), [("colours", "Dark"), ("text", "Projector")])
def test_another_look_keeps_the_plots(house: OpenHouse, arrive: Arrive, label: str, value: str) -> None:
    one = arrive(house(), "plot=lambda")
    one.run_on(2.0)
    one.visitor.wait_for(lambda _: all(len(plot[0]) > 12 for plot in plots(one.visitor)))
    old = looks(one.visitor)
    one.visitor.set_value(label, value)
    one.visitor.wait_for(lambda _: len(new := looks(one.visitor)) == 3 and all(a != b for a, b in zip(old, new, strict=True)))
    one.visitor.wait_for(lambda _: all(len(plot[0]) > 12 for plot in plots(one.visitor)))
    for times, *lines in plots(one.visitor):
        assert times[0] < 0.2 and np.isfinite(lines[0]).all()


@pytest.mark.parametrize("change", [("colours", "Dark"), ("more plots", "q")])
def test_plots_made_while_paused_are_not_empty(house: OpenHouse, arrive: Arrive, change: tuple[str, str]) -> None:
    one = arrive(house())
    one.run_on(1.0)
    press(one, "pause")
    old = looks(one.visitor)
    one.visitor.set_value(*change)
    one.visitor.wait_for(lambda _: looks(one.visitor) != old)
    count = 3 if change[0] == "more plots" else 2
    one.visitor.wait_for(lambda _: len(bodies(one.visitor, "GuiUplotMessage")) == count)
    one.visitor.wait_for(lambda _: all(len(plot[0]) > 5 for plot in plots(one.visitor)))


def test_the_last_step_before_a_pause_is_on_the_plot(house: OpenHouse, arrive: Arrive) -> None:
    one = arrive(house(), "dt=0.02")
    one.run_on(0.5)
    press(one, "pause")
    for _ in range(3):
        press(one, "step")
        newest = one.ask(lambda s: s.simulation.sample().time)
        one.visitor.wait_for(lambda _, newest=newest: abs(plots(one.visitor)[0][0][-1] - newest) < 1e-9)


def test_what_the_ghost_does_and_what_would_have_been_are_on_the_plots(house: OpenHouse, arrive: Arrive) -> None:
    one = arrive(house(), "whatif=1")
    one.run_on(1.0)
    own = len([row for row in plots(one.visitor)[0][1:] if len(row)])
    press(one, "ghost")
    one.run_on(0.5)
    # The ghost has a line beside that of the run, the same one as long as nothing was changed.
    one.visitor.wait_for(lambda _: len([row for row in plots(one.visitor)[0][1:] if len(row)]) == own + 1)
    times, distance, *_, ghost, _ = plots(one.visitor)[0]
    assert len(ghost) == len(times) > 9 and np.isfinite(ghost[:-1]).all() and np.allclose(ghost[:-1], distance[:-1])
    # A line whose first value is missing would leave the page without a range for its axis.
    assert all(np.isfinite(row[0]) for plot in plots(one.visitor) for row in plot if len(row))
    one.visitor.set_value(page_label("dm"), 250.0)
    one.visitor.wait_for(lambda _: len([row for row in plots(one.visitor)[0][1:] if len(row)]) == own + 2, 20.0)


def test_traffic_of_the_default_page(house: OpenHouse, arrive: Arrive, monkeypatch: pytest.MonkeyPatch) -> None:
    one = arrive(house())
    one.run_on(1.0)
    refreshes, payloads = [0], list[int]()
    take = one.visitor.mirror.take

    def count(message: dict[str, Any]) -> None:
        if message["type"] == "GuiUpdateMessage" and "data" in message["updates"]:
            refreshes[0] += 1
            payloads.append(len(message["updates"]["data"][0]))
        take(message)

    monkeypatch.setattr(one.visitor.mirror, "take", count)
    received = one.visitor.received
    frames, size, begin, clock = received.frames, received.bytes, one.session.simulation.time, time.perf_counter()
    one.run_on(3.0)
    simulated, wall = one.session.simulation.time - begin, time.perf_counter() - clock
    frames, size = received.frames - frames, received.bytes - size
    print(f"{frames / simulated:.0f} frames and {size / simulated / 1000:.0f} kB per simulated second, {simulated / wall:.2f}×")
    assert size / simulated <= 150_000
    # A frame simulates a tenth of a second at most; on a machine at leisure there are about 30 a second.
    assert frames / simulated >= 10
    assert 2 * 2 < refreshes[0] <= 2 * (10.0 * wall + 2.0)
    assert max(payloads) <= 200


@pytest.mark.parametrize(("dt", "batch", "seconds"), [(0.005, 7, 31.0), (0.00125, 50, 8.0), (0.02, 1, 47.0), (0.02, 40, 47.0)])
def test_bins_lose_no_dip(dt: float, batch: int, seconds: float) -> None:
    settings = RunSettings(dt=dt)
    simulation, buffer = Simulation(settings, 100_000), PlotBuffer()
    person = Autopilot(simulation.room, settings.guided, settings.seed)
    for step in range(round(seconds / dt)):
        simulation.step(person.target(simulation.time))
        if step % batch == 0:
            buffer.feed(simulation)
    buffer.feed(simulation)
    times, distance, critical, resting, squared = buffer.series((1, 2, 3, 4))
    table = simulation.history.table()
    # Bins cover the last 20 s; the oldest of them may begin a little later than the newest step minus 20 s.
    width = WINDOW / POINTS
    oldest = int(table[-1, 0] / width) - POINTS + 1
    shown = table[(table[:, 0] * (POINTS / WINDOW)).astype(int) >= oldest]
    assert len(times) == min(POINTS, math.ceil(seconds / width)) <= 200
    assert (np.diff(times) > 0.0).all() and times[-1] == table[-1, 0]
    assert times[-1] - times[0] <= WINDOW
    assert distance.min() == shown[:, COLUMN["d"]].min() and squared.max() == shown[:, COLUMN["e2"]].max()
    # Bin by bin, too.
    numbers = (shown[:, 0] * (POINTS / WINDOW)).astype(int)
    for i, number in enumerate(np.unique(numbers)):
        rows = shown[numbers == number]
        assert distance[i] == rows[:, COLUMN["d"]].min() and squared[i] == rows[:, COLUMN["e2"]].max()
        assert times[i] == rows[-1, 0]
    assert (critical == settings.law.critical_distance).all() and np.nanmin(resting) > 0.0


def test_a_reset_empties_the_bins() -> None:
    simulation, buffer = Simulation(RunSettings()), PlotBuffer()
    assert np.isnan(buffer.series((1,))[1]).all()
    for _ in range(500):
        simulation.step(None)
    buffer.feed(simulation)
    assert len(buffer.series((1,))[0]) > 15
    simulation.reset()
    for _ in range(60):
        simulation.step(None)
    buffer.feed(simulation)
    times = buffer.series((1,))[0]
    assert times[-1] == pytest.approx(59 * 0.005) and (np.diff(times) > 0.0).all() and len(times) == 3


def test_a_message_for_a_closed_tab_is_no_news(house: OpenHouse, arrive: Arrive, caplog: pytest.LogCaptureFixture) -> None:
    opened = house()
    witness = arrive(opened)
    for _ in range(10):
        arrive(opened).visitor.close()
    witness.wait(lambda _: set(live_sessions(opened)) == {witness.number})
    witness.run_on(0.1)
    assert [record.getMessage() for record in caplog.records if record.exc_info] == []
    with pytest.raises(websockets.InvalidStatus):
        SyncVisitor(opened.url, origin="https://evil.example")
