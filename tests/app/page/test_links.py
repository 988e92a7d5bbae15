"""What a link says is the start of its own tab; what it says badly is named, and never more than text; a link to a push of the duel in
lesson 6 replays it in another browser."""

import html
import re
from urllib.parse import quote

import numpy as np

from app.session.session import Session
from app.settings import Settings
from app.start import App
from app.web.headless_client import HeadlessClient
from scenes.rerun import rerun
from scenes.run_text import run_of_text
from scenes.settings import values
from scenes.targets import HandTarget
from tests.app.conftest import Arrive, Guest, OpenHouse, live_sessions
from tests.app.features.lessons.helpers import lessons_of
from tests.app.page.by_hand import USUAL, WRIST, chosen, control, run_on, see_plots, set_by_hand, visit
from tests.app.page.helpers import click, notes, shown
from tests.app.runtime.processes import until as wait_until
from tests.browser import PageAt, until, world_position


def test_a_second_tab_is_private_and_a_link_sets_it(house: OpenHouse, page_at: PageAt) -> None:
    opened = house()
    one = page_at(900, 640)
    first = visit(one, opened, "autopilot=0")
    other = page_at(900, 640)
    alerts: list[str] = []

    other.on("dialog", lambda dialog: alerts.append(dialog.message))
    other.on("dialog", lambda dialog: dialog.dismiss())
    bad = "law=%3Cimg%20src%3Dx%20onerror%3Dalert(1)%3E"
    second = visit(other, opened, f"rig=table&dm=0.1&n=10&theme=dark&plot=lambda&{bad}")
    expected = {"rig": "table", "dm": 0.1, "n": 10.0, "theme": "dark", "plot": "lambda"}
    assert chosen(second) == USUAL | expected
    # What could not be done is named, as plain text.
    other.get_by_text("law = '<img src=x onerror=alert(1)>'").wait_for()
    assert other.locator("img[src=x]").count() == 0 and alerts == []
    other.wait_for_function("document.documentElement.dataset.mantineColorScheme === 'dark'")
    for key, number in {"dm": "100", "n": "10"}.items():
        box = control(other, key).locator("input[type=text]").last
        until(other, lambda box=box, number=number: box.input_value() == number, key)
    see_plots(other, ("distance", "error", "activation λ"))
    # Neither sees the other.
    assert chosen(first) == USUAL | {"autopilot": False}
    assert one.evaluate("document.documentElement.dataset.mantineColorScheme") == "light"
    set_by_hand(one, first, "v")
    assert second.settings.run.law.nominal_velocity == 0.30
    assert not np.allclose(world_position(one, f"/arms/left{WRIST}"), world_position(other, f"/arms/left{WRIST}"), atol=0.05)
    other.close()
    until(one, lambda: len(live_sessions(opened)) == 1, "the session of the closed tab")
    run_on(one, first, 0.1)


MALICE = "<img src=x onerror=alert(1)>"


def test_a_bad_part_of_a_link_is_named_as_plain_text_and_the_rest_holds(house: OpenHouse, arrive: Arrive) -> None:
    opened, bad = house(), quote(MALICE)
    one = arrive(opened, f"rig=table&dm=9&law={bad}&n=10&{bad}=1&v=nan&initialCameraFov=1&websocket=x&seed=1.5")
    assert values(one.session.settings) == values(Settings()) | {"rig": "table", "n": 10.0}
    one.visitor.wait_for(lambda _: len(notes(one.visitor)) >= 5)
    said = notes(one.visitor)
    for named in ("dm = '9'", f"law = '{MALICE}'", f"'{MALICE}'", "v = 'nan'", "seed = '1.5'"):
        assert sum(named in note for note in said) == 1 + (named == f"'{MALICE}'"), (named, said)
    # The browser shows a notification's text as text; nothing else may carry it.
    one.run_on(0.3)
    texts: list[str] = []

    def read(visitor: HeadlessClient) -> bool:
        mirror = visitor.mirror
        others = [element for element in mirror.gui.values() if element["type"] != "NotificationShowMessage"]
        texts[:] = repr((others, mirror.nodes, mirror.commands)), repr(others)
        return True

    # In the thread that changes them.
    one.visitor.wait_for(read)
    assert "onerror" not in texts[0] and html.escape(MALICE) not in texts[1]
    assert notes(arrive(opened, "rig=table&speed=0.5").visitor) == []


def pushed(one: Guest) -> str:
    """A push, counted; the link to it."""
    click(one.visitor, "Next: observe")
    click(one.visitor, "Next: challenge")
    one.visitor.wait_for(lambda v: "You have five pushes" in shown(v))

    def pull(session: Session) -> None:
        pose = session.simulation.kinematics.hand_pose(session.arm)
        session.hold(HandTarget(pose.translation - np.array([0.15, 0.0, 0.0]), pose.rotation.copy()))

    # A push takes so much time of the run at most.
    one.ask(lambda s: s.change("speed", 0.25))
    for _ in range(4):
        one.ask(pull)
        one.run_on(0.1)
    click(one.visitor, "Count this push")
    one.visitor.wait_for(lambda v: "Push 1 of 5" in shown(v) and "&push=" in shown(v))
    found = re.search(r'value="[^"]*\?(lesson=hold&step=3&push=[^"]+)"', shown(one.visitor))
    assert found is not None
    return found[1]


def until_parked(app: App, one: Guest) -> None:
    """Wait until the server has noticed that a page is gone."""
    wait_until(lambda: one.number not in live_sessions(app))


def test_a_push_is_counted_and_its_link_replays_it_in_another_browser(house: OpenHouse, arrive: Arrive) -> None:
    app = house()
    one = arrive(app, "lesson=hold&step=3")
    link = pushed(one)
    push = lessons_of(one).walk.nearest
    assert push is not None
    other = arrive(app, link)
    other.visitor.wait_for(lambda v: "This is a push from a link" in shown(v) and "Try to touch it" in shown(v))
    other.wait(lambda s: s.player.replay is not None)
    player = other.session.player
    assert player.replay is not None
    table = rerun(push).table
    assert (
        rerun(player.replay.recorded).table.tobytes()
        == table.tobytes()
        == rerun(run_of_text(link.rpartition("=")[2])).table.tobytes()
    )
    # The replay itself, at its end.
    other.wait(lambda s: s.player.replay is not None and s.player.replay.step == len(table))
    ended = other.ask(lambda s: player.replay and player.replay.simulation.history.table(1)[0].tobytes())
    assert ended == table[-1].tobytes()
    # The visitor leaves it, and has a run: a lost line keeps that, and after a reload it waits behind the replay.
    tab = f"{link}&resume=0123456789abcdef0123456789abcdef"
    first = arrive(app, f"{tab}&opened=1")
    first.wait(lambda s: s.player.replay is not None)
    first.ask(lambda s: s.player.leave())
    first.run_on(0.1)
    steps = first.session.simulation.steps
    for opened, replays in (("1", False), ("2", True), ("3", True)):
        first.visitor.close()
        until_parked(app, first)
        again = arrive(app, f"{tab}&opened={opened}")
        again.visitor.wait_for(lambda v: "Try to touch it" in shown(v))
        assert again.session is first.session and again.session.simulation.steps >= steps
        if replays:
            again.wait(lambda s: s.player.replay is not None)
        assert (again.session.player.loaded != "") == replays
        first = again
    for damaged, why in ((link[:-3], "push: the link is damaged"), (f"{link}{'A' * 3500}", "push: is longer than 3000")):
        third = arrive(app, damaged)
        third.visitor.wait_for(lambda v, why=why: any(why in note for note in notes(v)))
        assert third.session.player.replay is None
