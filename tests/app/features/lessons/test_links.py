"""Tests of lessons beside those of the core in the file `test_links.py`."""

import re

import numpy as np
import pytest

from app.session.session import Session
from app.start import App
from scenes.rerun import rerun
from scenes.run_text import run_of_text
from scenes.targets import HandTarget
from tests.app.conftest import Arrive, Guest, OpenHouse, live_sessions
from tests.app.features.lessons.helpers import lessons_of
from tests.app.page.helpers import click, notes, shown
from tests.app.runtime.processes import until as wait_until


def pushed(one: Guest) -> str:
    """A push, counted; the link to it."""
    click(one.visitor, "Next: observe")
    click(one.visitor, "Next: challenge")
    one.visitor.wait_for(lambda v: "You have five pushes" in shown(v))

    def pull(session: Session) -> None:
        pose = session.simulation.kinematics.hand_pose(session.hand.arm)
        session.hand.hold(HandTarget(pose.translation - np.array([0.15, 0.0, 0.0]), pose.rotation.copy()))

    # A push may take a limited time of the run.
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


@pytest.mark.thorough
def test_a_push_is_counted_and_its_link_replays_it_in_another_browser(
    house: OpenHouse, arrive: Arrive
) -> None:
    app = house()
    one = arrive(app, "lesson=hold&step=3")
    link = pushed(one)
    push = lessons_of(one).walk.nearest
    assert push is not None
    other = arrive(app, link)
    other.visitor.wait_for(
        lambda v: "This is a push from a link" in shown(v) and "Try to touch it" in shown(v)
    )
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
    for damaged, why in (
        (link[:-3], "push: the link is damaged"),
        (f"{link}{'A' * 3500}", "push: is longer than 3000"),
    ):
        third = arrive(app, damaged)
        third.visitor.wait_for(lambda v, why=why: any(why in note for note in notes(v)))
        assert third.session.player.replay is None
