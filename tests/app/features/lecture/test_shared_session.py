"""All watchers of a lecture see the same session: scenes, replay, hidden tabs, pause, languages."""

from typing import Any

import pytest

from app.hosting.frame_loop import LIVELY, RESTING
from app.i18n.catalogue import pseudo
from app.session.actions import Pause, SetSetting
from app.settings import Settings
from app.start import App
from app.web.headless_client import CAMERA, HeadlessClient
from app.web.pages import HIDDEN, SHOWN
from scenes.settings import changed, values
from tests.app.conftest import Join, Made, OpenHouse, ask
from tests.app.features.lecture.lecture_room import lecture_of
from tests.app.hosting.test_hidden_tabs import drawn as frames_for
from tests.app.hosting.test_hidden_tabs import say
from tests.app.i18n.test_pages import assert_all_said, comes
from tests.app.page.helpers import bodies, shown
from tests.app.runtime.processes import until
from tests.app.stage.conftest import SCENES, drawn


def test_pages_of_a_lecture_show_no_greeting(house: OpenHouse, join: Join) -> None:
    lecture = house(lecture=True)
    teacher, student = join(lecture), join(lecture)
    assert "duet-welcome" not in shown(teacher) + shown(student)


def says_so(visitor: HeadlessClient) -> bool:
    return "This is the past" in shown(visitor) and "the past: " in shown(visitor)


def test_all_pages_see_a_replay_which_ends_when_the_teacher_leaves(house: OpenHouse, join: Join) -> None:
    opened = house(lecture=True)
    host = lecture_of(opened)
    session = host.session
    first = join(opened)
    first.wait_for(lambda v: v.mirror.grabbable)
    second = join(opened)
    first.wait_for(lambda _: session.simulation.time > 0.5)
    assert not says_so(second.visitor)
    first.set_value("replay", "Watch")
    for visitor in (first, second):
        visitor.wait_for(says_so)
    assert session.paused
    first.wait_for(lambda v: not v.mirror.grabbable)
    player = session.player
    first.wait_for(lambda _: player.replay is not None and not player.replay.playing)
    steps = ask(session, lambda s: s.simulation.steps)
    first.set_value("moment [s]", 0.25)
    for visitor in (first, second):
        visitor.wait_for(lambda v: "the past: 0.2 s" in shown(v))
    assert ask(session, lambda s: s.simulation.steps) == steps

    # The teacher leaves: the run continues for the others.
    first.close()
    second.wait_for(lambda v: not says_so(v))
    second.wait_for(lambda _: not session.paused and session.simulation.steps > steps)


def test_a_lecture_shows_every_scene_to_all(house: OpenHouse, join: Join) -> None:
    opened: App = house(lecture=True)
    first = join(opened)
    first.wait_for(lambda v: v.mirror.grabbable)
    second = join(opened)
    session = lecture_of(opened).session
    for scene in (*SCENES, "hold"):
        session.post(SetSetting("scene", scene))
        telling = {"ball": "/ball", "imitation": "/person/body", "first_task": "/wall"}.get(scene, "/room")
        for visitor in (first, second):
            visitor.wait_for(
                lambda v, t=telling, s=scene: t in v.mirror.nodes and session.simulation.settings.scene == s
            )
        if scene == "ball":
            first.wait_for(lambda v: v.mirror.grabbable == {"/ball"})
        # Only the operator's page has handles.
        assert not second.mirror.grabbable and not any(name.startswith("/gizmo") for name in drawn(second))
    # A late visitor sees only the present scene.
    third = join(opened)
    third.wait_for(lambda v: "/place/ring" in v.mirror.nodes)
    second.wait_for(lambda v: drawn(third) == drawn(second))
    assert values(session.settings) == values(Settings()) | {"scene": "hold"}


def test_a_hidden_tab_gets_no_scene_data_and_then_the_newest(by_hand: Made) -> None:
    opened = by_hand(lecture=True)
    opened.let_in()
    hidden, other = opened.let_in("lang=en"), opened.let_in("lang=en")

    def pose(one: Any) -> Any:
        return [
            node["wxyz"]
            for name, node in sorted(one.mirror.nodes.items())
            if name.startswith("/arms/left") and "wxyz" in node
        ]

    frames_for(opened, 0.5)
    say(opened, hidden, HIDDEN)
    # A batch may still be on its way; the notice, sent once the sender waits for the tab, arrives after it.
    _, number, _ = sorted(opened.house.server.get_clients())
    page = opened.house.server.page_of(number)
    assert page is not None and page.hidden
    until(lambda: opened.frame() or page._seen._waiters)  # type: ignore[attr-defined]
    opened.house.server.get_clients()[number].add_notification("all has come", "")
    hidden.wait_for(
        lambda one: any(note["title"] == "all has come" for note in bodies(one, "NotificationShowMessage"))
    )
    other.wait_for(lambda one: one.received.frames)
    before, seen = pose(hidden), hidden.received.frames
    first = pose(other)
    while pose(other) == first or other.received.frames < seen:
        opened.frame()
    assert pose(hidden) == before
    say(opened, hidden, SHOWN)
    opened.frame()
    hidden.wait_for(lambda one: pose(one) == pose(other))


def test_a_paused_session_draws_rarely_until_a_browser_sends_a_message(
    by_hand: Made, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened = by_hand(lecture=True)
    host = lecture_of(opened)
    teacher, student = opened.let_in(), opened.let_in("lang=en")
    shown: list[float] = []
    show = host._show_shared
    monkeypatch.setattr(host, "_show_shared", lambda frame: shown.append(frame.now) or show(frame))

    def count(seconds: float) -> int:
        shown.clear()
        frames_for(opened, seconds)
        return len(shown)

    host.session.post(Pause())
    count(2.0 * LIVELY)
    assert count(5.0) <= 5.0 / RESTING + 1
    for visitor in (teacher, student):
        visitor.send(CAMERA)
        until(host._is_dirty)
        # The wait above consumed the change; reset it for the next frame.
        host._heard = (0, 0)
        assert count(1.0) == 32
        count(2.0 * LIVELY)
    assert count(5.0) <= 5.0 / RESTING + 1
    host.session.post(Pause())
    assert count(1.0) == 32


def test_all_texts_of_a_lecture_are_translated(house: OpenHouse, join: Join) -> None:
    opened = house(changed(Settings(), "lang", "pseudo"), lecture=True, key="k")
    teacher = join(opened, "key=k")
    comes(teacher, pseudo("Join"))
    others = join(opened), join(opened, "key=wrong")
    for visitor in (teacher, *others):
        comes(visitor, pseudo("Live plots"))
        assert_all_said(visitor)
