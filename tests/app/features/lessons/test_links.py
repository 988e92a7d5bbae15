"""The link to a push replays it in another browser; see also `tests/app/page/test_links.py`."""

import re

import numpy as np
import pytest

from app.session import run_control
from app.session.session import Session
from app.start import App
from scenes.rerun import rerun
from scenes.run_text import run_of_text, run_text
from scenes.targets import HandTarget
from tests.app.conftest import Arrive, Guest, OpenHouse, live_sessions
from tests.app.features.lessons.helpers import lessons_of
from tests.app.features.lessons.student import duel, push
from tests.app.page.helpers import click, notes, shown
from tests.app.runtime.processes import until as wait_until


def pushed(one: Guest) -> str:
    """Link to a push that was made and counted."""
    click(one.visitor, "Next: observe")
    click(one.visitor, "Next: challenge")
    one.visitor.wait_for(lambda v: "You have five pushes" in shown(v))

    def pull(session: Session) -> None:
        pose = session.simulation.kinematics.hand_pose(session.hand.arm)
        session.hand.hold(HandTarget(pose.translation - np.array([0.15, 0.0, 0.0]), pose.rotation.copy()))

    # Slow, because a push may take only a limited time of the run.
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
    """Wait until the server has noticed a closed page."""
    wait_until(lambda: one.number not in live_sessions(app))


@pytest.fixture(scope="module")
def app(lasting_house: OpenHouse) -> App:
    return lasting_house()


@pytest.fixture(scope="module")
def link() -> str:
    """Link to a push of a session without a page."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(run_control, "perf_counter", lambda: 0.0)
        push(one := duel(), 0.25)
    nearest = one.run.walk.nearest
    assert nearest is not None
    return f"lesson=hold&step=3&push={run_text(nearest)}"


@pytest.mark.thorough
def test_a_push_is_counted_and_its_link_replays_it_in_another_browser(app: App, arrive: Arrive) -> None:
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
    table, replayed = rerun(push).table, rerun(player.replay.recorded).table
    linked = rerun(run_of_text(link.rpartition("=")[2])).table
    assert replayed.tobytes() == table.tobytes() == linked.tobytes()
    # The shown replay at its end.
    other.wait(lambda s: s.player.replay is not None and s.player.replay.step == len(table))
    ended = other.ask(lambda s: player.replay and player.replay.simulation.history.table(1)[0].tobytes())
    assert ended == table[-1].tobytes()


@pytest.mark.thorough
def test_a_lost_connection_keeps_the_run_and_a_reload_replays_the_link(
    app: App, arrive: Arrive, link: str
) -> None:
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


@pytest.mark.thorough
@pytest.mark.parametrize("damage", ["cut", "long"])
def test_a_damaged_link_to_a_push_is_named_and_replays_nothing(
    app: App, arrive: Arrive, link: str, damage: str
) -> None:
    damaged, why = {
        "cut": (link[:-3], "push: the link is damaged"),
        "long": (f"{link}{'A' * 3500}", "push: is longer than 3000"),
    }[damage]
    one = arrive(app, damaged)
    one.visitor.wait_for(lambda v: any(why in note for note in notes(v)))
    assert one.session.player.replay is None
