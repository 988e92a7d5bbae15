"""The past on the pages of others: a lecture sees it together, there is nothing to take hold of, and it ends with its presenter."""

from app.bench.headless_client import HeadlessClient
from app.classroom.lecture import LectureHost
from app.hosting.private_host import PrivateHost
from app.lessons.session.lesson_actions import Choose, GoTo, StartOrPause
from tests.app.conftest import HAND, Arrive, Join, OpenHouse, ask


def texts(visitor: HeadlessClient) -> str:
    return " ".join(str(element.get("content", "")) for element in list(visitor.mirror.gui.values()))


def says_so(visitor: HeadlessClient) -> bool:
    return "This is the past" in texts(visitor) and "the past: " in texts(visitor)


def test_a_lecture_looks_back_together_and_goes_on_when_the_lecturer_leaves(house: OpenHouse, join: Join) -> None:
    opened = house(lecture=True)
    assert isinstance(opened.host, LectureHost)
    session = opened.host.session
    first = join(opened)
    first.wait_for(lambda v: HAND in v.mirror.nodes)
    second = join(opened)
    first.wait_for(lambda _: session.simulation.time > 0.5)
    assert not says_so(second.visitor)
    first.set_value("replay", "Watch")
    for visitor in (first, second):
        visitor.wait_for(says_so)
    assert session.paused
    first.wait_for(lambda v: HAND not in v.mirror.nodes)
    operation = opened.host.controls.operation
    assert operation is not None and operation._keep is not None
    bar = operation._keep
    first.wait_for(lambda _: bar.shelf.player.replay is not None and not bar.shelf.player.replay.playing)
    steps = ask(session, lambda s: s.simulation.steps)
    first.set_value("moment [s]", 0.25)
    for visitor in (first, second):
        visitor.wait_for(lambda v: "the past: 0.2 s" in texts(v))
    assert ask(session, lambda s: s.simulation.steps) == steps

    # The one who shows it leaves: the run goes on, for those who are there.
    first.close()
    second.wait_for(lambda v: not says_so(v))
    second.wait_for(lambda _: not session.paused and session.simulation.steps > steps)


def test_a_lesson_that_goes_on_ends_the_past_and_keeps_its_run_waiting(house: OpenHouse, arrive: Arrive) -> None:
    opened = house()
    guest = arrive(opened)
    assert isinstance(opened.host, PrivateHost)
    stand = opened.host.visitors[guest.number]
    bar = stand.operation._keep
    assert bar is not None
    guest.ask(lambda _: stand.lessons.enter(0))
    guest.ask(lambda _: stand.lessons.act(Choose(2)))
    guest.ask(lambda _: stand.lessons.act(StartOrPause()))
    guest.wait(lambda s: s.simulation.time > 0.3)
    guest.visitor.set_value("replay", "Watch")
    guest.visitor.wait_for(says_so)
    guest.ask(lambda _: stand.lessons.act(GoTo(0, 1)))
    guest.visitor.wait_for(lambda v: not says_so(v))
    # The next step waits for an answer.
    assert guest.ask(lambda s: ("replay" in s.halt, s.paused, s.simulation.steps, stand.lessons.locked)) == (False, True, 0, True)
